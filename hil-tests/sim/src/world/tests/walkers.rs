use super::super::scene::Scene;
use super::*;

fn person(start_m: [f64; 2], route: Route, heed_m: f64) -> Walker {
    Walker {
        body: Body::Disc { radius_m: 0.2 },
        start_m,
        route,
        slowest_m_s: 0.5,
        fastest_m_s: 1.0,
        longest_rest_s: 0.5,
        heed_m,
        heed_behind_m: heed_m,
    }
}

fn standing_robot() -> World {
    world(vec![], vec![exact_robot("a", Pose::default())])
}

fn centre_m(world: &World, id: ObstacleId) -> [f64; 2] {
    let shape = world.obstacles().find(|(other, _)| *other == id).unwrap().1;
    match shape {
        Shape::Disc { centre_m, .. } => centre_m,
        Shape::Box { pose, .. } => [pose.x_m, pose.y_m],
        Shape::Wall(_) => unreachable!("no walker is a wall"),
    }
}

#[test]
fn a_path_is_walked_within_the_speeds_and_ends() {
    let mut world = standing_robot();
    let path = Route::Path(vec![[3.0, 3.0], [-3.0, 3.0]]);
    let id = world.add_walker(person([3.0, -3.0], path, 0.0)).unwrap();
    let mut last_m = centre_m(&world, id);
    for ms in 1..=30_000 {
        world.advance_to(START_NS + ms * MS);
        let now_m = centre_m(&world, id);
        let step_m = (now_m[0] - last_m[0]).hypot(now_m[1] - last_m[1]);
        assert!(step_m <= 1.001e-3, "{step_m} m in a millisecond");
        last_m = now_m;
    }
    assert!((last_m[0] + 3.0).abs() < 1e-9 && (last_m[1] - 3.0).abs() < 1e-9);
}

#[test]
fn walks_stay_in_their_region_and_follow_from_the_seed() {
    let walk = |seed| {
        let mut world = World::new(WorldConfig {
            seed,
            ..WorldConfig::default()
        })
        .unwrap();
        world.advance_to(START_NS);
        let route = Route::Wander {
            min_m: [-1.0, -2.0],
            max_m: [4.0, 2.0],
        };
        let id = world.add_walker(person([0.0, 0.0], route, 0.0)).unwrap();
        (1..=600)
            .map(|look| {
                world.advance_to(START_NS + look * 100 * MS);
                let [x, y] = centre_m(&world, id);
                assert!((-1.0..=4.0).contains(&x) && (-2.0..=2.0).contains(&y));
                [x, y]
            })
            .collect::<Vec<_>>()
    };
    assert_eq!(walk(1), walk(1));
    assert_ne!(walk(1), walk(2));
    let far = |at: &[f64; 2]| (at[0] - walk(1)[0][0]).hypot(at[1] - walk(1)[0][1]);
    assert!(walk(1).iter().map(far).fold(0.0, f64::max) > 1.0);
}

#[test]
fn who_sees_no_robot_runs_into_it_and_who_does_waits() {
    let mut world = standing_robot();
    let path = Route::Path(vec![[-3.0, 0.0]]);
    world
        .add_walker(person([3.0, 0.0], path.clone(), 0.0))
        .unwrap();
    world.advance_to(START_NS + 15_000 * MS);
    let truth = world.truth(0).unwrap();
    assert_eq!((truth.collisions, truth.run_into), (1, 1));
    assert_eq!(world.collisions(0)[0].cause, Cause::RunInto);

    let mut world = standing_robot();
    let id = world.add_walker(person([3.0, 0.0], path, 0.5)).unwrap();
    world.advance_to(START_NS + 15_000 * MS);
    let truth = world.truth(0).unwrap();
    assert_eq!(truth.collisions, 0);
    let [x, _] = centre_m(&world, id);
    assert!((0.32 + 0.2 + 0.4..0.32 + 0.2 + 0.6).contains(&x), "{x}");
}

#[test]
fn who_runs_into_a_robot_turns_elsewhere() {
    let mut world = standing_robot();
    let route = Route::Wander {
        min_m: [-1.0, -1.0],
        max_m: [1.0, 1.0],
    };
    for start_m in [[0.9, 0.9], [-0.9, 0.9], [0.9, -0.9]] {
        world
            .add_walker(person(start_m, route.clone(), 0.0))
            .unwrap();
    }
    let mut longest_ms = 0;
    let mut touching_ms = 0;
    for ms in 1..=120_000 {
        world.advance_to(START_NS + ms * MS);
        let truth = world.truth(0).unwrap();
        touching_ms = if truth.in_contact { touching_ms + 1 } else { 0 };
        longest_ms = longest_ms.max(touching_ms);
    }
    let truth = world.truth(0).unwrap();
    assert!(
        truth.collisions > 10 && truth.collisions == truth.run_into,
        "{truth:?}"
    );
    assert!(longest_ms <= 20, "it was covered for {longest_ms} ms");
}

#[test]
fn who_comes_from_behind_may_be_the_only_one_to_look() {
    let careful_behind = |from_x_m: f64| {
        let mut world = standing_robot();
        let path = Route::Path(vec![[-from_x_m, 0.0]]);
        let walker = Walker {
            heed_behind_m: 0.5,
            ..person([from_x_m, 0.0], path, 0.0)
        };
        world.add_walker(walker).unwrap();
        world.advance_to(START_NS + 15_000 * MS);
        world.truth(0).unwrap().collisions
    };
    assert_eq!((careful_behind(-3.0), careful_behind(3.0)), (0, 1));
}

#[test]
fn a_robot_that_drives_is_to_blame() {
    let mut world = standing_robot();
    world.add_obstacle(Obstacle::disc([2.0, 0.0], 0.1)).unwrap();
    drive(&mut world, 0, &wheels(6.0, 6.0), 7000);
    let collision = world.collisions(0)[0];
    assert_eq!(collision.cause, Cause::DroveInto, "{collision:?}");
    assert_eq!(world.truth(0).unwrap().run_into, 0);

    let mut world = standing_robot();
    let path = Route::Path(vec![[-3.0, 0.0]]);
    world.add_walker(person([3.0, 0.0], path, 0.0)).unwrap();
    drive(&mut world, 0, &wheels(4.0, 4.0), 7000);
    let collision = world.collisions(0)[0];
    assert_eq!(collision.cause, Cause::Met, "{collision:?}");
    assert!(collision.robot_m_s > 0.15 && collision.object_m_s > 0.45);
}

#[test]
fn a_lidar_sees_a_walker_where_it_is_at_each_beam() {
    let mut world = standing_robot();
    let path = Route::Path(vec![[2.0, 0.0]]);
    world
        .add_walker(Walker {
            slowest_m_s: 1.0,
            longest_rest_s: 0.0,
            ..person([3.0, 0.0], path, 0.0)
        })
        .unwrap();
    // It stops after one second, and the step in which it sets out, in the middle of this turn's measuring.
    let start_ns = START_NS + 962 * MS;
    world.advance_to(start_ns + 80 * MS);
    let mut finder = RangeFinder::new(&world, 0, RangeModel::default());
    finder.capture(&world, start_ns, 100 * MS);
    let mut distances_m = [0.0; RANGE_STEPS];
    finder.cast_exact(&mut distances_m);
    // The middle beam looks 37.9 ms after the turn began, 1.1 ms before the stop; the disc's edge is at 1.8 m then.
    let expected_m = 2.0 + 0.0011 - 0.2 - 0.28;
    assert!(
        (distances_m[384] - expected_m).abs() < 1e-4,
        "{}",
        distances_m[384]
    );
    // 16 steps on, 1.6 ms later, it stands (and is not hit in its middle).
    let angle_rad = 16.0 * std::f64::consts::TAU / STEPS_PER_TURN as f64;
    let direction = [angle_rad.cos(), angle_rad.sin()];
    let standing_m = geometry::ray_hit_disc_m([2.0, 0.0], 0.2, [0.28, 0.0], direction).unwrap();
    let later_m = distances_m[400];
    assert!((later_m - standing_m).abs() < 1e-9, "{later_m}");
}

#[test]
fn nonsense_walks_are_refused() {
    let mut world = standing_robot();
    let good = person([3.0, 0.0], Route::Path(vec![[1.0, 1.0]]), 0.0);
    let bad = [
        Walker {
            route: Route::Path(vec![]),
            ..good.clone()
        },
        Walker {
            fastest_m_s: 0.1,
            ..good.clone()
        },
        Walker {
            heed_m: f64::NAN,
            ..good.clone()
        },
        Walker {
            heed_behind_m: -1.0,
            ..good.clone()
        },
        Walker {
            body: Body::Disc { radius_m: -1.0 },
            ..good.clone()
        },
        Walker {
            route: Route::Wander {
                min_m: [1.0, 1.0],
                max_m: [0.0, 2.0],
            },
            ..good
        },
    ];
    for walker in bad {
        assert!(world.add_walker(walker.clone()).is_err(), "{walker:?}");
    }
    assert_eq!(world.obstacles().count(), 0);
}

#[test]
fn who_arrives_at_a_robot_has_run_into_it_though_it_stands_by_then() {
    let mut scene = Scene::default();
    let walks = Obstacle {
        velocity_m_s: [-1.0, 0.0],
        ..Obstacle::disc([1.0, 0.0], 0.2)
    };
    let id = scene.add(walks, 0).expect("a good one");
    let footprint = Footprint {
        front_m: 0.3,
        rear_m: 0.3,
        left_m: 0.3,
        right_m: 0.3,
    };
    let speed_m_s = |scene: &Scene, at_ns| {
        let touching = scene.touching(&footprint, &Pose::default(), at_ns);
        touching.map(|(speed_m_s, _)| speed_m_s)
    };
    let arrives_ns = 600_000_000;
    scene.redirect(id, arrives_ns, [0.4, 0.0], None, [0.0; 2]);
    assert_eq!(speed_m_s(&scene, arrives_ns), Some(1.0));
    assert_eq!(speed_m_s(&scene, arrives_ns + 1), Some(0.0), "it stands");
}
