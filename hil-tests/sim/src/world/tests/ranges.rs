use super::*;

const TURN_NS: u64 = 100 * MS;
const FRONT: usize = 384;
const LEFT: usize = FRONT + 256;
const RIGHT: usize = FRONT - 256;

fn finder(world: &World) -> RangeFinder {
    RangeFinder::new(world, 0, RangeModel::default())
}

#[test]
fn beams_in_a_room_are_exact() {
    let start = Pose::new(-0.28, 0.0, 0.0);
    let mut world = world(room(2.0), vec![exact_robot("a", start)]);
    world.advance_to(START_NS + TURN_NS);
    let mut finder = finder(&world);
    finder.capture(&world, START_NS, TURN_NS);
    let mut distances = [0.0; RANGE_STEPS];
    finder.cast_exact(&mut distances);
    for (step, distance) in distances.iter().enumerate() {
        let angle = (step as f64 - FRONT as f64) * std::f64::consts::TAU / 1024.0;
        let expected = 2.0 / angle.cos().abs().max(angle.sin().abs());
        assert!(
            (distance - expected).abs() < 1e-9,
            "{step}: {distance} {expected}"
        );
    }
}

#[test]
fn every_beam_meets_what_is_nearest_of_all() {
    let mut obstacles = room(3.0);
    obstacles.extend((0..24).map(|number| {
        let angle = f64::from(number) * 0.7;
        let from = [1.6 * angle.cos(), 1.4 * angle.sin()];
        let to = [from[0] + 0.3 * (3.0 * angle).sin(), from[1] + 0.25];
        match number % 4 {
            0 => Obstacle::disc(from, 0.05),
            _ => Obstacle::wall(from, to),
        }
    }));
    for theta_rad in [0.0, 0.4, -2.9, 40.0] {
        let start = Pose::new(0.1, -0.05, theta_rad);
        let mut world = world(obstacles.clone(), vec![exact_robot("a", start)]);
        world.advance_to(START_NS + TURN_NS);
        let mut finder = finder(&world);
        finder.capture(&world, START_NS, TURN_NS);
        let mut distances = [0.0; RANGE_STEPS];
        finder.cast_exact(&mut distances);
        let eye = start.compose(&Pose::new(0.28, 0.0, 0.0));
        let from = [eye.x_m, eye.y_m];
        for (step, distance) in distances.iter().enumerate() {
            let angle = (step as f64 - FRONT as f64) * std::f64::consts::TAU / 1024.0;
            let (sin, cos) = (eye.theta_rad + angle).sin_cos();
            let hits = world.obstacles().filter_map(|(_, shape)| match shape {
                Shape::Wall(wall) => wall.ray_hit_m(from, [cos, sin]),
                Shape::Disc { centre_m, radius_m } => {
                    ray_hit_disc_m(centre_m, radius_m, from, [cos, sin])
                }
                Shape::Box { .. } => None,
            });
            let nearest = hits.fold(f64::INFINITY, f64::min);
            // An edge that is just missed is farther by more than rounding.
            assert!(
                *distance == nearest || (distance - nearest).abs() < 1e-9,
                "{step}: {distance} {nearest}"
            );
        }
    }
}

#[test]
fn readings_have_the_devices_noise_and_codes() {
    let mut world = world(
        room(2.0),
        vec![exact_robot("a", Pose::new(-0.28, 0.0, 0.0))],
    );
    world.advance_to(START_NS + TURN_NS);
    let mut finder = finder(&world);
    let mut readings = [0u16; RANGE_STEPS];
    let (mut sum, mut squares, n) = (0.0, 0.0, 2000);
    for _ in 0..n {
        finder.capture(&world, START_NS, TURN_NS);
        finder.cast(&mut readings);
        let error = f64::from(readings[FRONT]) - 2000.0;
        sum += error;
        squares += error * error;
    }
    let mean = sum / f64::from(n);
    let deviation = (squares / f64::from(n)).sqrt();
    assert!(mean.abs() < 2.0, "{mean}");
    assert!((18.0..22.0).contains(&deviation), "{deviation}");
    assert!(readings[..44].iter().all(|r| *r == 19));
    assert!(readings[726..].iter().all(|r| *r == 19));
}

#[test]
fn far_walls_fade_away() {
    let read = |distance_m: f64| {
        let wall = Obstacle::wall([distance_m, -9.0], [distance_m, 9.0]);
        let mut world = world(
            vec![wall],
            vec![exact_robot("a", Pose::new(-0.28, 0.0, 0.0))],
        );
        world.advance_to(START_NS + TURN_NS);
        let mut finder = finder(&world);
        let mut readings = [0u16; RANGE_STEPS];
        let mut lengths = 0;
        for _ in 0..200 {
            finder.capture(&world, START_NS, TURN_NS);
            finder.cast(&mut readings);
            lengths += u32::from(readings[FRONT] >= 20);
            assert!(readings[FRONT] <= 5600);
            assert_eq!(readings[LEFT + 40], 0);
        }
        lengths
    };
    assert_eq!(read(3.9), 200);
    assert!((50..150).contains(&read(4.8)));
    assert_eq!(read(5.7), 0);
}

#[test]
fn other_robots_are_seen_and_the_own_body_is_not() {
    let other = Pose::new(2.0, 0.0, 0.0);
    let robots = vec![exact_robot("a", Pose::default()), exact_robot("b", other)];
    let mut world = world(vec![], robots);
    world.advance_to(START_NS + TURN_NS);
    let mut finder = finder(&world);
    finder.capture(&world, START_NS, TURN_NS);
    let mut distances = [0.0; RANGE_STEPS];
    finder.cast_exact(&mut distances);
    assert!((distances[FRONT] - (2.0 - 0.08 - 0.28)).abs() < 1e-9);
    assert_eq!(distances[LEFT], f64::INFINITY);
    assert_eq!(distances[0], f64::INFINITY);
}

#[test]
fn each_beam_leaves_at_its_own_time() {
    let wall = Obstacle::wall([5.0, -9.0], [5.0, 9.0]);
    let mut world = world(vec![wall], vec![exact_robot("a", Pose::default())]);
    drive(&mut world, 0, &wheels(8.0, 8.0), 1000);
    let turn_start_ns = world.now_ns();
    let start_m = world.truth(0).unwrap().pose.x_m;
    drive(&mut world, 0, &wheels(8.0, 8.0), 80);
    let mut finder = finder(&world);
    finder.capture(&world, turn_start_ns, TURN_NS);
    let mut distances = [0.0; RANGE_STEPS];
    finder.cast_exact(&mut distances);
    for step in [RIGHT + 156, FRONT, LEFT - 156] {
        let time_s = 0.1 * step as f64 / 1024.0;
        let angle = (step as f64 - FRONT as f64) * std::f64::consts::TAU / 1024.0;
        let expected = (5.0 - start_m - 0.42 * time_s - 0.28) / angle.cos();
        assert!(
            (distances[step] - expected).abs() < 1e-3,
            "{step}: {} {expected}",
            distances[step]
        );
    }
}

#[test]
fn moving_obstacles_are_where_they_are_at_the_beams_time() {
    let mut world = world(vec![], vec![exact_robot("a", Pose::new(-0.28, 0.0, 0.0))]);
    let disc = Obstacle {
        velocity_m_s: [2.0, 0.0],
        ..Obstacle::disc([1.0, 0.0], 0.2)
    };
    world.add_obstacle(disc).unwrap();
    world.advance_to(START_NS + 80 * MS);
    let mut finder = finder(&world);
    finder.capture(&world, START_NS, TURN_NS);
    let mut distances = [0.0; RANGE_STEPS];
    finder.cast_exact(&mut distances);
    let expected = 0.8 + 2.0 * 0.1 * FRONT as f64 / 1024.0;
    assert!(
        (distances[FRONT] - expected).abs() < 1e-3,
        "{}",
        distances[FRONT]
    );
}
