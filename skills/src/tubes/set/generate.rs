//! From parameters, footprint and sensor to a set of tubes.
//!
//! **Step.** A sample is judged by the nearest beam, which passes it at up to q = r·Δα/2. For a thing of `sample_step_m`
//! to hold a sample in spite of that, samples are `sample_step_m` − 3·q apart: 2·q for a disc, 3·q for the corner of a box.
//!
//! **Samples out of view** within one footprint of `base_link` become cells of the tube's mask on the near grid, with
//! all cells out of view that the tube sweeps there; farther ones refuse the tube.

use super::border::{MAX_TURN_RAD, Path, Sweep, sample_border};
use super::report::{RefusedTube, TubeReport, UnseenSample};
use super::tube_set::{Row, Tube, TubeSet};
use crate::scan::ScanGeometry;
use crate::tubes::error::{Refusal, TubeError};
use crate::tubes::memory::grid::NearGrid;
use description::geometry::{Footprint, Point2};
use description::keys::{KeyError, Section};
use description::robot::{Horizon, Tubes, check_mount};
use std::collections::BTreeMap;

/// The share of `sample_step_m` that must remain as step.
const MIN_STEP_SHARE: f64 = 0.25;

/// How the sensor sees a point of `base_link`.
enum Sight {
    Beam { beam: usize, range_m: f64 },
    BeyondRange { range_m: f64 },
    Nothing,
}

fn look(geometry: &ScanGeometry, point: Point2) -> Sight {
    let in_laser = geometry.mount.inverse_transform(point);
    let range_m = in_laser.norm_m();
    match geometry.nearest_beam(in_laser.direction_rad()) {
        _ if range_m >= geometry.range_max_m => Sight::BeyondRange { range_m },
        Some(beam) if range_m >= geometry.range_min_m => Sight::Beam { beam, range_m },
        _ => Sight::Nothing,
    }
}

/// Distance from `base_link` within which memory may answer for the sensor: one footprint.
fn near_m(footprint: &Footprint) -> f64 {
    footprint.length_m().max(footprint.width_m())
}

fn check(tubes: &Tubes, footprint: &Footprint, geometry: &ScanGeometry) -> Result<(), TubeError> {
    Section::check(footprint).map_err(|error| error.below("footprint"))?;
    Section::check(tubes).map_err(|error| error.below("tubes"))?;
    if tubes.horizons.is_empty() {
        return Err(KeyError::new("tubes.horizons", "none", "at least one").into());
    }
    if let Some(error) = tubes.contradictions(footprint).into_iter().next() {
        return Err(error.into());
    }
    geometry.validate()?;
    check_mount(&geometry.mount, footprint)?;
    Ok(())
}

impl TubeSet {
    /// Samples the border of every tube and maps the samples to beams. Tubes that the sensor cannot judge are refused,
    /// and the report says why.
    ///
    /// # Errors
    /// [`TubeError`]: parameters, footprint or sensor are refused, or not one tube can be judged.
    pub fn generate(
        parameters: &Tubes,
        footprint: &Footprint,
        geometry: &ScanGeometry,
    ) -> Result<(Self, TubeReport), TubeError> {
        check(parameters, footprint, geometry)?;
        let cell_m = parameters.sample_step_m / 2.0;
        let grid = NearGrid::new(near_m(footprint) + parameters.augment_m + cell_m, cell_m);
        let (mut set, report) = Self::generate_on(grid, parameters, footprint, geometry)?;
        if parameters.by_hand_augment_m < parameters.augment_m {
            let slowest = |rows: &[Horizon]| rows.first().copied().into_iter().collect();
            let narrow = Tubes {
                horizons: slowest(&parameters.horizons),
                backward_horizons: slowest(&parameters.backward_horizons),
                augment_m: parameters.by_hand_augment_m,
                ..parameters.clone()
            };
            let narrow = Self::generate_on(grid, &narrow, footprint, geometry);
            set.narrow = narrow.ok().map(|(narrow, _)| Box::new(narrow));
        }
        Ok((set, report))
    }

    fn generate_on(
        grid: NearGrid,
        parameters: &Tubes,
        footprint: &Footprint,
        geometry: &ScanGeometry,
    ) -> Result<(Self, TubeReport), TubeError> {
        let mut generator = Generator {
            parameters,
            footprint,
            geometry,
            grid,
            blind_cells: Vec::new(),
            tubes: Vec::new(),
            sample_beams: Vec::new(),
            sample_ranges_m: Vec::new(),
            mask_words: Vec::new(),
            report: TubeReport::default(),
        };
        generator.find_blind_cells();
        let mut rows = Vec::new();
        // The longest of each direction first.
        let ahead = parameters.horizons.iter().rev().map(|row| (*row, false));
        let behind = parameters.backward_horizons.iter().rev();
        let steps = parameters.omega_steps as usize;
        for (horizon, backward) in ahead.chain(behind.map(|row| (*row, true))) {
            let row = Row {
                horizon,
                backward,
                length_m: horizon.length_m(),
                curvature_step_1_m: parameters.omega_step_rad_s() / horizon.speed_m_s,
            };
            rows.push(row);
            for step in 0..steps {
                let from_middle = step as f64 - (steps / 2) as f64;
                generator.tube(row, from_middle * row.curvature_step_1_m)?;
            }
        }
        generator.finish(rows, parameters.horizons.len())
    }
}

struct Generator<'a> {
    parameters: &'a Tubes,
    footprint: &'a Footprint,
    geometry: &'a ScanGeometry,
    grid: NearGrid,
    /// Cells near and out of view, outside the robot.
    blind_cells: Vec<usize>,
    tubes: Vec<Tube>,
    sample_beams: Vec<u16>,
    sample_ranges_m: Vec<f32>,
    mask_words: Vec<u64>,
    report: TubeReport,
}

impl Generator<'_> {
    fn find_blind_cells(&mut self) {
        let reach_m = self.grid.cell_m() * 0.5;
        let near_m = near_m(self.footprint);
        for cell in 0..self.grid.cells() {
            let centre = self.grid.centre(cell);
            let partly_blind = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
                .iter()
                .any(|(x, y)| {
                    let corner = centre + Point2::new(x * reach_m, y * reach_m);
                    matches!(look(self.geometry, corner), Sight::Nothing)
                });
            if partly_blind && !self.footprint.contains(centre) && centre.norm_m() <= near_m {
                self.blind_cells.push(cell);
            }
        }
    }

    fn tube(&mut self, row: Row, curvature_1_m: f64) -> Result<(), TubeError> {
        let Row {
            horizon, backward, ..
        } = row;
        let path = Path {
            curvature_1_m,
            length_m: if backward {
                -row.length_m
            } else {
                row.length_m
            },
        };
        let first_sample = self.sample_beams.len();
        let first_word = self.mask_words.len();
        let mut tube = Tube {
            first_sample: first_sample as u32,
            samples: 0,
            first_word: first_word as u32,
            words: 0,
            grid_word: 0,
            refused: false,
            backward,
        };
        match self.samples_of(horizon, path) {
            Ok(mask) => {
                tube.samples = (self.sample_beams.len() - first_sample) as u32;
                tube.grid_word = self.add_mask(&mask) as u32;
                tube.words = (self.mask_words.len() - first_word) as u32;
                self.report.tubes += 1;
                self.report.backward += usize::from(backward);
            }
            Err(why) => {
                tube.refused = true;
                self.report.refused.push(RefusedTube {
                    horizon,
                    backward,
                    curvature_1_m,
                    why,
                });
            }
        }
        self.tubes.push(tube);
        let samples = self.sample_beams.len();
        if samples > u32::MAX as usize / 2 {
            return Err(TubeError::TooLarge { samples });
        }
        Ok(())
    }

    /// Adds the samples of one tube; gives the mask of what memory must answer for.
    fn samples_of(&mut self, horizon: Horizon, path: Path) -> Result<Vec<u64>, Refusal> {
        let inner_side_m = if path.curvature_1_m > 0.0 {
            self.footprint.left_m
        } else {
            self.footprint.right_m
        };
        let radius_m = 1.0 / path.curvature_1_m.abs();
        if radius_m <= inner_side_m {
            return Err(Refusal::TurnsOnTheSpot { radius_m });
        }
        if path.angle_rad().abs() > MAX_TURN_RAD {
            return Err(Refusal::TurnsTooFar {
                angle_rad: path.angle_rad(),
            });
        }
        let sample_step_m = self.parameters.sample_step_m;
        let augment_m = self.parameters.augment_m;
        let mut points = Vec::new();
        sample_border(self.footprint, path, augment_m, sample_step_m, &mut points);
        let farthest_m = points
            .iter()
            .map(|&point| point.distance_m(self.geometry.mount.position()))
            .fold(0.0, f64::max);
        let beam_gap_m = farthest_m * self.geometry.angle_step_rad;
        let step_m = sample_step_m - 1.5 * beam_gap_m;
        if step_m < MIN_STEP_SHARE * sample_step_m {
            return Err(Refusal::BeamsTooCoarse {
                beam_gap_m,
                allowed_m: (1.0 - MIN_STEP_SHARE) * sample_step_m / 1.5,
            });
        }
        points.clear();
        sample_border(self.footprint, path, augment_m, step_m, &mut points);

        let mut by_beam: BTreeMap<usize, f64> = BTreeMap::new();
        let mut unseen = Vec::new();
        for &point in &points {
            match look(self.geometry, point) {
                Sight::Beam { beam, range_m } => {
                    let farthest_m = by_beam.entry(beam).or_insert(range_m);
                    *farthest_m = farthest_m.max(range_m);
                }
                Sight::BeyondRange { range_m } => {
                    return Err(Refusal::BeyondRange {
                        range_m,
                        range_max_m: self.geometry.range_max_m,
                    });
                }
                Sight::Nothing if point.norm_m() <= near_m(self.footprint) => unseen.push(point),
                Sight::Nothing => {
                    return Err(Refusal::Unseen {
                        x_m: point.x_m,
                        y_m: point.y_m,
                    });
                }
            }
        }
        self.report.samples += points.len();
        self.report.compared += by_beam.len();
        for (beam, range_m) in by_beam {
            self.sample_beams.push(beam as u16);
            self.sample_ranges_m.push(range_m as f32);
        }
        let mask = self.mask(path, !unseen.is_empty());
        let unseen = unseen.into_iter().map(|point| UnseenSample {
            curvature_1_m: path.curvature_1_m,
            horizon,
            backward: path.length_m < 0.0,
            point,
        });
        self.report.unseen.extend(unseen);
        Ok(mask)
    }

    /// The cells out of view that the tube sweeps, and those within `augment_m` of its border out of view.
    fn mask(&self, path: Path, any_unseen: bool) -> Vec<u64> {
        let mut mask = vec![0u64; self.grid.words()];
        if !any_unseen {
            return mask;
        }
        let cell_m = self.grid.cell_m();
        let mut border = Vec::new();
        sample_border(self.footprint, path, 0.0, cell_m / 2.0, &mut border);
        border.retain(|&point| {
            !matches!(look(self.geometry, point), Sight::Beam { .. })
                && point.norm_m() <= near_m(self.footprint)
        });
        // Floor that must be known free is kept on a grid of the same cell size, at any angle to this one.
        let margin_cells = if path.length_m < 0.0 { 1.5 } else { 0.5 };
        let margin_m = self.parameters.augment_m + margin_cells * cell_m;
        for point in border {
            for cell in self.grid.around(point, margin_m) {
                let centre = self.grid.centre(cell);
                if point.distance_m(centre) <= margin_m && !self.footprint.contains(centre) {
                    mask[cell / 64] |= 1 << (cell % 64);
                }
            }
        }
        // Only the beginning of the path comes near.
        let longest_m = 2.0 * (near_m(self.footprint) + self.footprint.radius_m());
        let near = Path {
            length_m: path.length_m.clamp(-longest_m, longest_m),
            ..path
        };
        let sweep = Sweep::new(self.footprint, near, cell_m / 2.0);
        for &cell in &self.blind_cells {
            let is_set = mask[cell / 64] & (1 << (cell % 64)) != 0;
            if !is_set && sweep.covers(self.footprint, self.grid.centre(cell)) {
                mask[cell / 64] |= 1 << (cell % 64);
            }
        }
        mask
    }

    /// Keeps the words of a mask between its first and last that are not zero; gives the place of the first.
    fn add_mask(&mut self, mask: &[u64]) -> usize {
        let Some(first) = mask.iter().position(|&word| word != 0) else {
            return 0;
        };
        let last = mask.iter().rposition(|&word| word != 0).unwrap_or(first);
        self.mask_words.extend_from_slice(&mask[first..=last]);
        first
    }

    fn finish(mut self, rows: Vec<Row>, ahead: usize) -> Result<(TubeSet, TubeReport), TubeError> {
        if self.report.tubes == 0
            && let Some(first) = self.report.refused.first()
        {
            return Err(TubeError::NothingLeft {
                tubes: self.tubes.len(),
                first: first.why,
            });
        }
        let mut looked_at = vec![false; self.geometry.beams];
        for &beam in &self.sample_beams {
            looked_at[beam as usize] = true;
        }
        self.report.beams = looked_at.iter().filter(|&&looked_at| looked_at).count();
        self.report.bytes = self.sample_beams.len() * (size_of::<u16>() + size_of::<f32>())
            + self.mask_words.len() * size_of::<u64>()
            + self.tubes.len() * size_of::<Tube>();
        let set = TubeSet {
            parameters: self.parameters.clone(),
            footprint: *self.footprint,
            geometry: *self.geometry,
            grid: self.grid,
            rows: rows.into_boxed_slice(),
            ahead,
            steps: self.parameters.omega_steps as usize,
            tubes: self.tubes.into_boxed_slice(),
            sample_beams: self.sample_beams.into_boxed_slice(),
            sample_ranges_m: self.sample_ranges_m.into_boxed_slice(),
            mask_words: self.mask_words.into_boxed_slice(),
            narrow: None,
        };
        Ok((set, self.report))
    }
}
