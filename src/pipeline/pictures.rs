//! Pictures of a run: source and result of each pose beside each other, and where the result is bad.

use std::{
    borrow::Cow,
    collections::BTreeMap,
    sync::{Mutex, MutexGuard, PoisonError},
};

use mimesh_render::{
    Canvas, Cell, Colour, Direction, Dot, Paint, Picture, Rect, Scale, Size, UpAxis, View,
    colour::{CRIMSON, FAINT, INK, SAND, STEEL, WHITE},
    legend, sheet,
};
use nalgebra::Point3;

use super::{
    PictureSettings, Up, ViewFrom,
    check::Prepared,
    judge::{Judgement, Verdict},
    poses::spread,
};
use crate::{
    core::{
        mesh::{Surface, SurfacePoint},
        stage::Measured,
    },
    page::{Image, Pictures},
};

/// Poses with a small picture, at most; of more poses some spread over all.
const MOST: usize = 100;
/// Poses with a large picture.
const WORST: usize = 6;
/// Pixels of one mesh in a small, and in a large picture.
const SMALL: u32 = 240;
const LARGE: u32 = 400;
/// Pixels of a mesh at rest.
const REST: u32 = 480;

/// Takes pictures while poses stream by.
pub struct Gallery<'a> {
    prepared: &'a Prepared,
    /// Of source and target.
    looks: [Look; 2],
    /// Poses that get a small picture.
    chosen: Vec<bool>,
    taken: Mutex<Taken>,
}

/// What there is to see of a pose.
#[derive(Clone, Copy, Debug)]
pub struct Shot<'a> {
    /// Its name.
    pub name: &'a str,
    /// The source, for its surface.
    pub source: Option<&'a [Point3<f64>]>,
    /// The result, for the target's mesh.
    pub result: &'a [Point3<f64>],
    /// What metrics say.
    pub judgement: &'a Judgement,
    /// What is to be said of it.
    pub verdict: Option<&'a Verdict>,
    /// How near its worst figure comes to being bad.
    pub strain: f64,
}

#[derive(Default)]
struct Taken {
    /// Small pictures by number of pose.
    small: BTreeMap<usize, (String, Picture)>,
    /// Large ones of the worst so far, worst first: how bad, number, picture.
    large: Vec<(Badness, usize, String, Picture)>,
}

/// How bad a pose is; the larger the worse.
type Badness = (super::judge::Level, f64);

/// Where meshes are looked at from.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// The side.
    pub direction: Direction,
    /// The axis that points up.
    pub up: UpAxis,
}

impl From<PictureSettings> for Look {
    /// That of the source.
    fn from(settings: PictureSettings) -> Self {
        let direction = match settings.view {
            ViewFrom::ThreeQuarter => Direction::ThreeQuarter,
            ViewFrom::Front => Direction::Front,
            ViewFrom::Side => Direction::Side,
            ViewFrom::Top => Direction::Top,
        };
        let up = match settings.up {
            Up::X => UpAxis::X,
            Up::Y => UpAxis::Y,
            Up::Z => UpAxis::Z,
        };
        Self { direction, up }
    }
}

impl Look {
    /// That of the target.
    pub fn of_target(settings: PictureSettings) -> Self {
        PictureSettings { up: settings.target_up.unwrap_or(settings.up), ..settings }.into()
    }

    /// The view of everything in `positions`.
    pub fn at(&self, positions: &[Point3<f64>]) -> View {
        View::fit(positions.iter().copied(), self.direction, self.up)
    }
}

impl<'a> Gallery<'a> {
    /// For the poses of `prepared`.
    pub fn new(prepared: &'a Prepared) -> Self {
        let mut chosen = vec![false; prepared.poses.len()];
        spread(prepared.poses.len(), MOST).into_iter().for_each(|i| chosen[i] = true);
        let settings = prepared.pipeline.pictures;
        Self { prepared, looks: [settings.into(), Look::of_target(settings)], chosen, taken: Mutex::default() }
    }

    /// Takes pose `i`.
    pub fn take(&self, i: usize, shot: &Shot<'_>) {
        let name = shot.name;
        let strip = |pixels: u32| self.strip(pixels, shot);
        if self.chosen[i] {
            let picture = strip(SMALL);
            self.taken().small.insert(i, (name.into(), picture));
        }
        let badness = badness(shot);
        let place = |taken: &Taken| {
            let before =
                |other: &(Badness, usize, String, Picture)| worse(&other.0, &badness).then(i.cmp(&other.1)).is_gt();
            taken.large.iter().filter(|other| before(other)).count()
        };
        // Most poses are not among the worst and need no large picture; asked again once it is drawn.
        if place(&self.taken()) < WORST {
            let picture = strip(LARGE);
            let mut taken = self.taken();
            let at = place(&taken);
            taken.large.insert(at, (badness, i, name.into(), picture));
            taken.large.truncate(WORST);
        }
    }

    fn taken(&self) -> MutexGuard<'_, Taken> {
        self.taken.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Source, result and what is wrong with it, side by side.
    fn strip(&self, pixels: u32, shot: &Shot<'_>) -> Picture {
        let Shot { source, result, judgement, verdict, .. } = *shot;
        let Prepared { source: from, target, .. } = self.prepared;
        let shown = field(judgement, verdict);
        let mut picture = Picture::new(pixels * if shown.is_some() { 3 } else { 2 }, pixels, WHITE);
        let titled = |picture: &mut Picture, cell: u32, title: &str| {
            picture.text((cell * pixels + 6) as i32, 4, title, Size::Small, INK);
        };
        if let Some(source) = source {
            let view = self.looks[0].at(&from.surface.positions).and(&self.looks[0].at(source));
            let mut canvas = Canvas::new(pixels, pixels, view);
            canvas.mesh(source, &from.surface.triangles, &Paint::Plain(STEEL));
            canvas.draw_onto(&mut picture, 0, 0);
            titled(&mut picture, 0, "source");
        }
        let Ok(posed) = target.surface.from_mesh(result) else { return picture };
        let view = self.looks[1].at(&target.surface.positions).and(&self.looks[1].at(&posed));
        let mut canvas = Canvas::new(pixels, pixels, view);
        canvas.mesh(&posed, &target.surface.triangles, &Paint::Plain(SAND));
        canvas.draw_onto(&mut picture, pixels as i32, 0);
        titled(&mut picture, 1, "result");
        if let Some(measured) = shown {
            let field = Field { values: &measured.field, high: measured.field_high, unit: measured.field_unit };
            coloured(&mut picture, 2 * pixels, &target.surface, &posed, view, field);
            titled(&mut picture, 2, measured.field_unit.split(',').next().unwrap_or_default());
        }
        picture
    }

    /// All small pictures on one sheet, as PNG.
    pub fn sheet(&self) -> Vec<u8> {
        let taken = self.taken();
        let cells: Vec<Cell> = taken
            .small
            .values()
            .map(|(name, picture)| Cell { picture: picture.clone(), caption: name.clone() })
            .collect();
        let rows: Vec<Vec<Cell>> = cells.chunks(2).map(<[Cell]>::to_vec).collect();
        let title = self.prepared.file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        sheet(&title, &rows).png()
    }

    /// The pictures for the page.
    pub fn pictures(self) -> Pictures {
        let alt = |name: &str| format!("source, result and errors of pose {name}");
        let taken = self.taken.into_inner().unwrap_or_else(PoisonError::into_inner);
        Pictures {
            rest: rests(self.prepared, self.looks),
            worst: taken.large.iter().map(|(_, _, name, picture)| image(name, alt(name), picture)).collect(),
            sheet: taken.small.values().map(|(name, picture)| image(name, alt(name), picture)).collect(),
        }
    }
}

/// Pixels below a mesh for the legend of its colours.
const LEGEND: u32 = 36;

/// A picture for a page.
pub fn image(name: &str, alt: String, picture: &Picture) -> Image {
    Image { name: name.into(), alt, png: picture.small_png(), size: [picture.width, picture.height] }
}

/// Both meshes at rest with numbered markers, from the side asked for and from behind.
fn rests(prepared: &Prepared, looks: [Look; 2]) -> Vec<Image> {
    let behind = match looks[0].direction {
        Direction::ThreeQuarter => Direction::Angles { yaw: 220.0, pitch: 18.0 },
        Direction::Front => Direction::Angles { yaw: 180.0, pitch: 0.0 },
        Direction::Side => Direction::Angles { yaw: 270.0, pitch: 0.0 },
        _ => Direction::Angles { yaw: 0.0, pitch: -90.0 },
    };
    let source: Vec<SurfacePoint> = prepared.markers.iter().map(|marker| marker.source).collect();
    let target: Vec<SurfacePoint> = prepared.markers.iter().map(|marker| marker.target).collect();
    let sides =
        [("source", &prepared.source, source, STEEL, looks[0]), ("target", &prepared.target, target, SAND, looks[1])];
    let mut images = Vec::new();
    for (name, side, points, colour, look) in sides {
        for (look, suffix) in [(look, ""), (Look { direction: behind, ..look }, ", from behind")] {
            let picture = with_points(&side.surface, &points, look, REST, colour);
            let alt = format!("the {name} at rest{suffix}, with {} numbered markers", points.len());
            images.push(image(&format!("{name}{suffix}"), alt, &picture));
        }
    }
    images
}

/// A mesh with numbered points, `size` pixels wide and high.
pub fn marked(surface: &Surface, points: &[SurfacePoint], look: Look, size: u32) -> Picture {
    with_points(surface, points, look, size, STEEL)
}

fn with_points(surface: &Surface, points: &[SurfacePoint], look: Look, size: u32, colour: Colour) -> Picture {
    let mut picture = Picture::new(size, size, WHITE);
    let mut canvas = Canvas::new(size, size, look.at(&surface.positions));
    canvas.mesh(&surface.positions, &surface.triangles, &Paint::Plain(colour));
    let dot = |(k, point): (usize, &SurfacePoint)| Dot {
        at: point.position(surface, &surface.positions),
        label: Some((k + 1).to_string()),
        colour: CRIMSON,
    };
    canvas.dots(&points.iter().enumerate().map(dot).collect::<Vec<_>>());
    let drawn = canvas.draw_onto(&mut picture, 0, 0);
    if drawn.hidden > 0 {
        let note = format!("{} behind", drawn.hidden);
        picture.text(6, size as i32 - 16, &note, Size::Small, INK);
    }
    picture.frame(Rect { x: 0, y: 0, width: size, height: size }, FAINT);
    picture
}

/// A mesh as it stands; with `errors` of its file's vertices in percent, coloured by them.
pub fn plain(surface: &Surface, errors: Option<&[f64]>, look: Look, size: u32) -> Picture {
    let mut picture = Picture::new(size, size, WHITE);
    let view = look.at(&surface.positions);
    match errors {
        Some(errors) => {
            let field = Field { values: errors, high: 5.0, unit: "error, %" };
            coloured(&mut picture, 0, surface, &surface.positions, view, field);
        }
        None => {
            let mut canvas = Canvas::new(size, size, view);
            canvas.mesh(&surface.positions, &surface.triangles, &Paint::Plain(SAND));
            canvas.draw_onto(&mut picture, 0, 0);
        }
    }
    picture
}

/// How bad each vertex of a mesh's file is.
#[derive(Clone, Copy)]
struct Field<'f> {
    values: &'f [f64],
    /// The end of the colours.
    high: f64,
    /// What the values are.
    unit: &'f str,
}

/// Draws a mesh in the colours of a metric's field (for its file's vertices) at `x` of `picture`, with a legend below.
fn coloured(picture: &mut Picture, x: u32, surface: &Surface, posed: &[Point3<f64>], view: View, field: Field<'_>) {
    let size = picture.height;
    let values = on_surface(surface, field.values);
    let over = values.iter().any(|value| *value > field.high);
    let scale = Scale { over, ..Scale::new(0.0, field.high) };
    let mut canvas = Canvas::new(size, size - LEGEND, view);
    canvas.mesh(posed, &surface.triangles, &Paint::Values { values: &values, scale: &scale });
    canvas.draw_onto(picture, x as i32, 0);
    let place = Rect { x: x as i32 + 8, y: (size - LEGEND) as i32, width: size - 16, height: LEGEND - 2 };
    legend(picture, place, &scale, field.unit);
}

/// What is shown in colour: the point error if there is one, else what the verdict is about, else the stretch.
fn field<'m>(judgement: &'m Judgement, verdict: Option<&Verdict>) -> Option<&'m Measured> {
    let of = |name: &str| {
        let found = judgement.measured.iter().find(|(metric, measured)| metric == name && !measured.field.is_empty());
        found.map(|(_, measured)| measured)
    };
    let reasons = verdict.into_iter().flat_map(|verdict| &verdict.reasons).map(|reason| reason.metric.as_str());
    let wanted = std::iter::once("point_error").chain(reasons).chain(["edge_stretch"]);
    wanted.into_iter().find_map(of).or_else(|| {
        let any = judgement.measured.iter().find(|(_, measured)| !measured.field.is_empty());
        any.map(|(_, measured)| measured)
    })
}

/// Values of the mesh's vertices for those of its surface.
fn on_surface<'f>(surface: &Surface, field: &'f [f64]) -> Cow<'f, [f64]> {
    let same =
        surface.representative.len() == field.len() && (0..).zip(&surface.representative).all(|(v, copy)| v == *copy);
    if same {
        return Cow::Borrowed(field);
    }
    surface.representative.iter().map(|&v| field.get(v as usize).copied().unwrap_or(f64::NAN)).collect()
}

/// Of poses of one level those with the largest errors are worst, or where nothing is known those nearest to being bad.
fn badness(shot: &Shot<'_>) -> Badness {
    let level = shot.verdict.map(|verdict| verdict.level).unwrap_or_default();
    let errors = shot.judgement.measured.iter().find(|(name, _)| name == "point_error");
    let error = errors.and_then(|(_, measured)| measured.figures.number("mean"));
    (level, error.unwrap_or(shot.strain))
}

fn worse(a: &Badness, b: &Badness) -> std::cmp::Ordering {
    a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
}
