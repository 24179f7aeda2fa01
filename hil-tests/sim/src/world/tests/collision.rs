use super::*;

#[test]
fn a_wall_stops_the_robot_and_lets_it_back_off() {
    let wall = Obstacle::wall([1.0, -2.0], [1.0, 2.0]);
    let mut world = world(vec![wall], vec![exact_robot("a", Pose::default())]);
    drive(&mut world, 0, &wheels(8.0, 8.0), 3000);
    let truth = world.truth(0).unwrap();
    assert!(
        truth.pose.x_m <= 0.68 && truth.pose.x_m > 0.679,
        "{truth:?}"
    );
    assert_eq!((truth.collisions, truth.min_clearance_m), (1, 0.0));
    drive(&mut world, 0, &wheels(-8.0, -8.0), 1000);
    let truth = world.truth(0).unwrap();
    assert!(
        truth.pose.x_m < 0.35 && truth.clearance_m > 0.3,
        "{truth:?}"
    );
    drive(&mut world, 0, &wheels(8.0, 8.0), 2000);
    assert_eq!(world.truth(0).unwrap().collisions, 2);
}

#[test]
fn robots_hit_each_other() {
    let facing = Pose::new(2.0, 0.1, std::f64::consts::PI);
    let robots = vec![exact_robot("a", Pose::default()), exact_robot("b", facing)];
    let mut world = world(vec![], robots);
    let before = world.truth(0).unwrap();
    assert!(
        (before.clearance_m - (2.0 - 0.64)).abs() < 1e-9,
        "{before:?}"
    );
    drive(&mut world, 0, &wheels(8.0, 8.0), 5000);
    let (a, b) = (world.truth(0).unwrap(), world.truth(1).unwrap());
    assert!((1.355..=1.36).contains(&a.pose.x_m), "{a:?}");
    assert_eq!((a.collisions, b.collisions), (1, 0));
    assert!(b.min_clearance_m < 1e-3 && b.pose == facing);
}

#[test]
fn a_moving_disc_runs_into_a_standing_robot() {
    let mut world = world(vec![], vec![exact_robot("a", Pose::default())]);
    let disc = Obstacle {
        velocity_m_s: [-1.0, 0.0],
        ..Obstacle::disc([2.0, 0.0], 0.1)
    };
    let id = world.add_obstacle(disc).unwrap();
    world.advance_to(START_NS + 1000 * MS);
    let truth = world.truth(0).unwrap();
    assert!(
        (truth.clearance_m - (2.0 - 1.0 - 0.1 - 0.32)).abs() < 2e-3,
        "{truth:?}"
    );
    assert_eq!(truth.collisions, 0);
    world.advance_to(START_NS + 2500 * MS);
    assert_eq!(world.truth(0).unwrap().collisions, 1);
    assert!(world.remove_obstacle(id) && !world.remove_obstacle(id));
    assert_eq!(world.obstacles().count(), 0);
}

#[test]
fn a_box_in_the_way_can_be_removed() {
    let mut world = world(vec![], vec![exact_robot("a", Pose::default())]);
    let id = world
        .add_obstacle(Obstacle::fixed(Shape::Box {
            pose: Pose::new(1.0, 0.0, 0.3),
            length_m: 0.4,
            width_m: 0.4,
        }))
        .unwrap();
    drive(&mut world, 0, &wheels(8.0, 8.0), 3000);
    let truth = world.truth(0).unwrap();
    assert!(truth.collisions == 1 && truth.pose.x_m < 0.6, "{truth:?}");
    world.remove_obstacle(id);
    drive(&mut world, 0, &wheels(8.0, 8.0), 3000);
    let truth = world.truth(0).unwrap();
    assert!(truth.collisions == 1 && truth.pose.x_m > 1.5, "{truth:?}");
}

#[test]
fn nonsense_is_refused() {
    let robot = |change: fn(&mut RobotModel)| {
        let mut model = RobotModel::new("a", Pose::default());
        change(&mut model);
        let robots = vec![model];
        let obstacles = vec![Obstacle::wall([5.0, 0.0], [5.0, 1.0])];
        World::new(WorldConfig {
            robots,
            obstacles,
            ..WorldConfig::default()
        })
        .map(|_| ())
    };
    assert!(robot(|_| ()).is_ok());
    let changes: [fn(&mut RobotModel); 5] = [
        |m| m.wheelbase_m = 0.0,
        |m| m.wheel_diameter_m = f64::NAN,
        |m| m.start.x_m = f64::INFINITY,
        |m| m.wheel_scale_error = 1.5,
        |m| m.start.x_m = 4.9,
    ];
    for change in changes {
        let error = robot(change).unwrap_err().to_string();
        assert!(error.starts_with("robot \"a\": "), "{error}");
    }
    let twice = vec![
        exact_robot("a", Pose::default()),
        exact_robot("a", Pose::new(3.0, 0.0, 0.0)),
    ];
    assert!(
        World::new(WorldConfig {
            robots: twice,
            ..WorldConfig::default()
        })
        .is_err()
    );
    let mut world = world(vec![], vec![]);
    assert!(
        world
            .add_obstacle(Obstacle::disc([0.0, 0.0], -1.0))
            .is_err()
    );
    assert!(
        world
            .add_obstacle(Obstacle::disc([f64::NAN, 0.0], 1.0))
            .is_err()
    );
    assert!(
        world
            .robot_index("b")
            .unwrap_err()
            .to_string()
            .contains("\"b\"")
    );
    assert_eq!(world.truth(3), None);
}

#[test]
fn a_robot_that_is_carried_stands_where_it_is_put_unless_something_is_there() {
    let [far, there] = [Pose::new(9.0, 0.0, 0.0), Pose::new(2.0, 0.0, 0.0)];
    let robots = vec![exact_robot("a", Pose::default()), exact_robot("b", far)];
    let mut world = world(room(20.0), robots);
    drive(&mut world, 0, &wheels(8.0, 8.0), 1000);
    let drove = world.truth(0).unwrap();
    world.carry(0, there).unwrap();
    world.advance_to(START_NS + 3000 * MS);
    let truth = world.truth(0).unwrap();
    assert_eq!((truth.pose, truth.twist), (there, Twist::default()));
    assert_eq!(truth.distance_m, drove.distance_m);
    assert_eq!(world.pose_at(0, START_NS + 2900 * MS), Some(there));
    let refused = world.carry(1, there).unwrap_err().to_string();
    assert!(refused.contains("\"b\""), "{refused}");
    assert!(world.carry(1, Pose::new(f64::NAN, 0.0, 0.0)).is_err());
    assert_eq!(world.truth(1).unwrap().pose, far);
}
