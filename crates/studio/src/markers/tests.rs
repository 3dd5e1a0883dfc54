//! Laws of the document.

use std::collections::BTreeSet;

use mimesh_core::{
    mesh::{Mesh, Surface},
    testkit::meshes,
};
use mimesh_markers::{MarkerMesh, MeshRole};
use proptest::prelude::*;

use super::{
    document::{MarkerDocument, same},
    edit::{Axis, Edit, EditResult, Op},
    pair::{Content, Origin, Point, Side, Status, TrianglePoint, VertexPoint},
};

struct Two(Mesh, Surface);

impl Two {
    fn new() -> Self {
        let sphere = meshes::icosphere(2);
        let mesh = Mesh::from_triangles(sphere.positions, &sphere.triangles);
        let surface = Surface::new(&mesh).unwrap();
        Self(mesh, surface)
    }

    fn on(&self) -> [MarkerMesh<'_>; 2] {
        MeshRole::BOTH.map(|role| MarkerMesh { role, mesh: &self.0, surface: &self.1 })
    }
}

fn vertex(vertex: u32) -> Option<Point> {
    Some(Point::Vertex(VertexPoint { vertex }))
}

fn edit(base: u64, id: &str, client: &str, ops: Vec<Op>) -> Edit {
    Edit { project: None, base, id: id.into(), client: client.into(), ops }
}

fn add(name: &str, v: u32) -> Op {
    Op::Add { name: Some(name.into()), note: None, source: vertex(v), target: vertex(v) }
}

fn document(two: &Two, names: &[&str]) -> MarkerDocument {
    let mut document = MarkerDocument::new([]);
    let ops = names.iter().zip(0..).map(|(name, v)| add(name, v)).collect();
    document.edit(&edit(1, "first", "", ops), two.on()).unwrap();
    document
}

fn of(pair: u64, side: Side, v: u32) -> Op {
    Op::Move { pair, side, point: vertex(v) }
}

#[test]
fn edits_of_different_pairs_and_aspects_are_merged() {
    let two = Two::new();
    let mut document = document(&two, &["a", "b"]);
    let base = document.revision();
    let one = document.edit(&edit(base, "1", "x", vec![of(1, Side::Source, 7)]), two.on()).unwrap();
    let other =
        document.edit(&edit(base, "2", "y", vec![of(2, Side::Source, 8), of(1, Side::Target, 9)]), two.on()).unwrap();
    assert!(one.conflicts.is_empty() && other.conflicts.is_empty(), "{other:?}");
    assert_eq!(document.pairs()[0].content.points, [vertex(7), vertex(9)]);
    // The same point conflicts, unless it is the same change or the same page.
    let op = |v| vec![of(1, Side::Source, v), Op::Rename { pair: 1, name: Some("c".into()) }];
    let late = document.edit(&edit(base, "3", "y", op(11)), two.on()).unwrap();
    assert_eq!((late.conflicts.len(), late.conflicts[0].op, late.conflicts[0].pair), (1, 0, Some(1)));
    assert_eq!(document.pairs()[0].content.name.as_deref(), Some("c"));
    assert!(document.edit(&edit(base, "4", "z", vec![of(1, Side::Source, 7)]), two.on()).unwrap().conflicts.is_empty());
    assert!(
        document.edit(&edit(base, "5", "x", vec![of(1, Side::Source, 12)]), two.on()).unwrap().conflicts.is_empty()
    );
}

#[test]
fn what_was_deleted_or_changed_meanwhile_is_a_conflict() {
    let two = Two::new();
    let mut document = document(&two, &["a", "b"]);
    let base = document.revision();
    document.edit(&edit(base, "1", "x", vec![Op::Delete { pair: 1 }, of(2, Side::Source, 9)]), two.on()).unwrap();
    let ops = vec![of(1, Side::Source, 5), Op::Delete { pair: 1 }, Op::Delete { pair: 2 }, Op::Delete { pair: 99 }];
    let late = document.edit(&edit(base, "2", "y", ops), two.on()).unwrap();
    let conflicts: Vec<_> = late.conflicts.iter().map(|conflict| (conflict.op, conflict.pair)).collect();
    assert_eq!(conflicts, [(0, Some(1)), (2, Some(2)), (3, Some(99))]);
    assert_eq!(document.pairs().len(), 1);
}

#[test]
fn a_page_does_not_pass_over_what_it_has_not_seen_by_a_change_before_it() {
    let two = Two::new();
    let mut document = document(&two, &["a"]);
    let base = document.revision();
    let status = |status| Op::Status { pair: 1, status };
    document.edit(&edit(base, "1", "x", vec![status(Status::Proposed)]), two.on()).unwrap();
    // A move to where the point is moves nothing, so nobody stands for the pair.
    document.edit(&edit(base, "2", "y", vec![of(1, Side::Source, 0)]), two.on()).unwrap();
    assert_eq!(document.pairs()[0].content.status, Status::Proposed);
    // One that confirms the proposal does not make its status the page's own.
    let ops = vec![of(1, Side::Source, 7), status(Status::Skipped)];
    let late = document.edit(&edit(base, "3", "y", ops), two.on()).unwrap();
    assert_eq!(late.conflicts.iter().map(|conflict| conflict.op).collect::<Vec<_>>(), [1]);
    assert_eq!(document.pairs()[0].content.status, Status::Confirmed);
}

#[test]
fn an_edit_that_is_sent_twice_is_done_once() {
    let two = Two::new();
    let mut document = document(&two, &["a"]);
    let again = edit(document.revision(), "same", "x", vec![add("b", 5)]);
    let first = document.edit(&again, two.on()).unwrap();
    let (revision, second) = (document.revision(), document.edit(&again, two.on()).unwrap());
    assert_eq!((first, revision, document.pairs().len()), (second, document.revision(), 2));
}

#[test]
fn points_and_names_that_cannot_be_are_refused_one_by_one() {
    let two = Two::new();
    let mut document = document(&two, &["a"]);
    let on = |triangle, barycentric| Some(Point::Triangle(TrianglePoint { triangle, barycentric }));
    let points = [
        vertex(162),
        on(320, [1.0, 0.0, 0.0]),
        on(0, [0.5, 0.6, 0.5]),
        on(0, [-0.1, 0.6, 0.5]),
        on(0, [f64::NAN, 0.5, 0.5]),
        on(0, [f64::INFINITY, 0.0, 0.0]),
    ];
    let mut ops: Vec<Op> = points.iter().map(|&point| Op::Move { pair: 1, side: Side::Source, point }).collect();
    ops.push(Op::Add { name: None, note: None, source: None, target: None });
    ops.push(add("a", 3));
    ops.push(Op::Rename { pair: 1, name: Some("x\u{7}".into()) });
    ops.push(Op::Rename { pair: 1, name: Some("\u{e000}".into()) });
    ops.push(Op::Rename { pair: 1, name: Some("x".repeat(201)) });
    let count = ops.len();
    let EditResult { conflicts, added, .. } = document.edit(&edit(2, "1", "", ops), two.on()).unwrap();
    assert_eq!((conflicts.len(), added), (count, vec![None, None]));
    // Both points of a pair are not taken away, and rounding is put right.
    let ops = vec![
        Op::Move { pair: 1, side: Side::Source, point: None },
        Op::Move { pair: 1, side: Side::Target, point: None },
        Op::Move { pair: 1, side: Side::Source, point: on(0, [1.0 + 1e-7, -1e-7, 0.0]) },
    ];
    let result = document.edit(&edit(document.revision(), "2", "", ops), two.on()).unwrap();
    assert_eq!(result.conflicts.iter().map(|conflict| conflict.op).collect::<Vec<_>>(), [1]);
    assert_eq!(document.pairs()[0].content.points[0], on(0, [1.0, 0.0, 0.0]));
}

#[test]
fn a_moved_proposal_is_confirmed_and_proposals_are_replaced() {
    let two = Two::new();
    let mut document = document(&two, &["a"]);
    let proposal = |v, name: &str| Content {
        name: Some(name.into()),
        points: [vertex(v), vertex(v)],
        status: Status::Proposed,
        confidence: Some(0.5),
        ..Content::default()
    };
    document.propose(vec![proposal(3, "p"), proposal(4, "q"), proposal(5, "a")]);
    let names: Vec<_> = document.pairs().iter().map(|pair| pair.content.name.clone()).collect();
    assert_eq!(names, [Some("a".into()), Some("p".into()), Some("q".into()), None]);
    let moved = document.edit(&edit(document.revision(), "1", "", vec![of(2, Side::Source, 9)]), two.on()).unwrap();
    assert!(moved.conflicts.is_empty() && document.pairs()[1].content.status == Status::Confirmed);
    document.propose(vec![proposal(4, "q"), proposal(6, "r")]);
    let pairs: Vec<_> = document.pairs().iter().map(|pair| (pair.id, pair.content.name.clone())).collect();
    assert_eq!(pairs, [(1, Some("a".into())), (2, Some("p".into())), (3, Some("q".into())), (5, Some("r".into()))]);
    assert!(!document.propose(vec![proposal(4, "q"), proposal(6, "r")]), "the same proposals change nothing");
    // A person has clicked this point of the target in the meantime.
    let clicked = Content { points: [vertex(7), document.pairs()[1].content.points[1]], ..proposal(7, "s") };
    assert!(
        !document.propose(vec![proposal(4, "q"), proposal(6, "r"), clicked]),
        "a proposal beside a click is left out"
    );
}

#[test]
fn what_an_edit_changes_and_changes_back_has_not_changed() {
    let two = Two::new();
    let mut document = document(&two, &["a", "b"]);
    let (base, first) = (document.revision(), document.pairs()[0].changes.clone());
    let status = |status| Op::Status { pair: 1, status };
    let back = || vec![status(Status::Proposed), status(Status::Confirmed)];
    document.edit(&edit(base, "1", "x", back()), two.on()).unwrap();
    assert_eq!((document.revision(), &document.pairs()[0].changes), (base, &first));
    // Beside a change of another pair too, so that nobody conflicts with what nobody changed.
    let with_other = [back(), vec![of(2, Side::Source, 9)]].concat();
    document.edit(&edit(base, "2", "x", with_other), two.on()).unwrap();
    assert_eq!((document.revision(), &document.pairs()[0].changes), (base + 1, &first));
    let late = document.edit(&edit(base, "3", "y", vec![status(Status::Skipped)]), two.on()).unwrap();
    assert!(late.conflicts.is_empty());
}

#[test]
fn mirroring_adds_partners_once() {
    let two = Two::new();
    let mut document = MarkerDocument::new([]);
    // A vertex off the plane.
    let off = two.0.positions.iter().position(|p| p.x > 0.5).unwrap() as u32;
    document.edit(&edit(1, "1", "", vec![add("left ear", off)]), two.on()).unwrap();
    let mirror = || vec![Op::Mirror { axis: Axis::X, pair: None, source_offset: None, target_offset: Some(0.0) }];
    let first = document.edit(&edit(document.revision(), "2", "", mirror()), two.on()).unwrap();
    assert_eq!(first.mirrored.map(|mirrored| mirrored.added), Some(1));
    assert_eq!(document.pairs()[1].content.name.as_deref(), Some("right ear"));
    let again = document.edit(&edit(document.revision(), "3", "", mirror()), two.on()).unwrap();
    assert_eq!(again.mirrored.map(|mirrored| mirrored.added), Some(0));
    document.undo(document.revision()).unwrap();
    assert_eq!(document.pairs().len(), 1);
    // A proposal has no partner until somebody stands for it.
    let status = |status| vec![Op::Status { pair: 1, status }];
    document.edit(&edit(document.revision(), "4", "", status(Status::Proposed)), two.on()).unwrap();
    let mirrored = document.edit(&edit(document.revision(), "5", "", mirror()), two.on()).unwrap().mirrored.unwrap();
    assert_eq!((mirrored.added, mirrored.left.len()), (0, 1));
}

#[test]
fn one_pair_is_mirrored_alone() {
    let two = Two::new();
    let mut document = MarkerDocument::new([]);
    let mut off = (0..).zip(&two.0.positions).filter(|(_, p)| p.x > 0.3).map(|(v, _)| v);
    let [a, b] = [off.next().unwrap(), off.next().unwrap()];
    document.edit(&edit(1, "1", "", vec![add("left ear", a), add("left eye", b)]), two.on()).unwrap();
    // Whoever names it stands for it.
    let status = vec![Op::Status { pair: 2, status: Status::Proposed }];
    document.edit(&edit(document.revision(), "2", "", status), two.on()).unwrap();
    let mut mirror = |id: &str, pair| {
        let op = Op::Mirror { axis: Axis::X, pair: Some(pair), source_offset: None, target_offset: None };
        document.edit(&edit(document.revision(), id, "", vec![op]), two.on()).unwrap().mirrored.unwrap()
    };
    assert_eq!(mirror("3", 2).added, 1);
    let again = mirror("4", 2);
    assert_eq!((again.added, again.left[0].reason.as_str()), (0, "its partner is there already"));
    assert_eq!(mirror("5", 99).left[0].pair, 99);
    assert_eq!(document.pairs().len(), 3);
    assert_eq!(document.pairs()[2].content.name.as_deref(), Some("right eye"));
}

#[test]
fn stages_see_complete_pairs_alone_and_each_point_once() {
    let two = Two::new();
    let mut document = document(&two, &["a", "b", "c", "d"]);
    let ops = vec![
        Op::Move { pair: 1, side: Side::Target, point: None },
        Op::Status { pair: 2, status: Status::Skipped },
        of(4, Side::Source, 2),
    ];
    document.edit(&edit(document.revision(), "1", "", ops), two.on()).unwrap();
    assert_eq!(document.usable(two.on()), [2]);
    let problems = document.problems(two.on());
    assert_eq!(problems.len(), 1);
    assert_eq!((problems[0].0, problems[0].1), (4, Side::Source));
}

fn op() -> impl Strategy<Value = Op> {
    let side = prop_oneof![Just(Side::Source), Just(Side::Target)];
    let point = prop_oneof![
        1 => Just(None),
        4 => (0u32..170).prop_map(vertex),
        2 => (0u32..330, 0.0..1.0f64, 0.0..1.0f64).prop_map(|(triangle, a, b)| {
            let (a, b) = if a + b > 1.0 { (1.0 - a, 1.0 - b) } else { (a, b) };
            Some(Point::Triangle(TrianglePoint { triangle, barycentric: [a, b, 1.0 - a - b] }))
        }),
    ];
    let name = prop::option::of("[a-f]{1,2}");
    prop_oneof![
        (name.clone(), point.clone(), point.clone()).prop_map(|(name, source, target)| Op::Add {
            name,
            note: None,
            source,
            target
        }),
        (1u64..12, side, point).prop_map(|(pair, side, point)| Op::Move { pair, side, point }),
        (1u64..12, name.clone()).prop_map(|(pair, name)| Op::Rename { pair, name }),
        (1u64..12, name).prop_map(|(pair, note)| Op::Note { pair, note }),
        (1u64..12, 0usize..3).prop_map(|(pair, k)| Op::Status {
            pair,
            status: [Status::Confirmed, Status::Proposed, Status::Skipped][k]
        }),
        (1u64..12).prop_map(|pair| Op::Delete { pair }),
        (1u64..12, prop::option::of(1u64..12)).prop_map(|(pair, before)| Op::Reorder { pair, before }),
    ]
}

/// Edits of several pages, each with how far behind it is.
fn edits() -> impl Strategy<Value = Vec<(Vec<Op>, u64, usize)>> {
    prop::collection::vec((prop::collection::vec(op(), 1..4), 0u64..5, 0usize..3), 1..25)
}

fn play(document: &mut MarkerDocument, two: &Two, edits: &[(Vec<Op>, u64, usize)]) -> Vec<EditResult> {
    let one = |(i, (ops, behind, client)): (usize, &(Vec<Op>, u64, usize))| {
        let base = document.revision().saturating_sub(*behind).max(1);
        document.edit(&edit(base, &i.to_string(), &client.to_string(), ops.clone()), two.on()).unwrap()
    };
    edits.iter().enumerate().map(one).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::default())]

    #[test]
    fn documents_stay_sound_whatever_pages_send(edits in edits()) {
        let two = Two::new();
        let mut document = MarkerDocument::new([]);
        let mut before = document.revision();
        for (i, one) in edits.iter().enumerate() {
            let base = document.revision().saturating_sub(one.1).max(1);
            let result = document.edit(&edit(base, &i.to_string(), "c", one.0.clone()), two.on()).unwrap();
            prop_assert!(document.revision() >= before && document.revision() <= before + 1);
            before = document.revision();
            let adds = one.0.iter().filter(|op| matches!(op, Op::Add { .. })).count();
            prop_assert_eq!(result.added.len(), adds);
            let pairs = document.pairs();
            let ids: BTreeSet<u64> = pairs.iter().map(|pair| pair.id).collect();
            prop_assert_eq!(ids.len(), pairs.len());
            let names: Vec<_> = pairs.iter().filter_map(|pair| pair.content.name.as_ref()).collect();
            prop_assert_eq!(names.iter().collect::<BTreeSet<_>>().len(), names.len());
            prop_assert!(pairs.iter().all(|pair| pair.content.points != [None, None] && pair.revision() <= document.revision()));
        }
    }

    #[test]
    fn undo_and_redo_lead_through_all_states(edits in edits()) {
        let two = Two::new();
        let mut document = MarkerDocument::new([]);
        let mut states = vec![document.pairs().to_vec()];
        for (i, (ops, ..)) in edits.iter().enumerate() {
            document.edit(&edit(document.revision(), &i.to_string(), "", ops.clone()), two.on()).unwrap();
            if !same(document.pairs(), &states[states.len() - 1]) {
                states.push(document.pairs().to_vec());
            }
        }
        for state in states.iter().rev().skip(1) {
            document.undo(document.revision()).unwrap();
            prop_assert!(same(document.pairs(), state));
        }
        prop_assert!(document.undo(document.revision()).is_err());
        for state in states.iter().skip(1) {
            document.redo(document.revision()).unwrap();
            prop_assert!(same(document.pairs(), state));
        }
        prop_assert!(document.redo(document.revision()).is_err());
    }

    #[test]
    fn pages_that_touch_different_pairs_never_conflict(moves in prop::collection::vec((1u64..6, 0u32..162), 1..30)) {
        // Each page has a pair of its own, and never sees what the others do.
        let two = Two::new();
        let mut document = document(&two, &["a", "b", "c", "d", "e"]);
        let base = document.revision();
        for (i, (pair, v)) in moves.iter().enumerate() {
            let one = edit(base, &i.to_string(), &pair.to_string(), vec![of(*pair, Side::Source, *v)]);
            prop_assert!(document.edit(&one, two.on()).unwrap().conflicts.is_empty());
        }
        for pair in 1..6u64 {
            let last = moves.iter().rev().find(|(other, _)| *other == pair);
            if let Some((_, v)) = last {
                prop_assert_eq!(document.pairs()[pair as usize - 1].content.points[0], vertex(*v));
            }
        }
    }

    #[test]
    fn nobody_overwrites_what_he_has_not_seen(edits in edits()) {
        let two = Two::new();
        let mut document = MarkerDocument::new([]);
        for (i, (ops, behind, _)) in edits.iter().enumerate() {
            let base = document.revision().saturating_sub(*behind).max(1);
            let before = document.pairs().to_vec();
            // Every edit comes from another page.
            document.edit(&edit(base, &i.to_string(), &format!("page {i}"), ops.clone()), two.on()).unwrap();
            for pair in &before {
                let Some(after) = document.pairs().iter().find(|after| after.id == pair.id) else {
                    prop_assert!(pair.revision() <= base, "a pair was deleted that had changed");
                    continue;
                };
                for aspect in pair.content.differences(&after.content) {
                    // Moving a proposal confirms it, whoever proposed it.
                    let is_confirmed = after.content.status == Status::Confirmed && pair.content.status == Status::Proposed;
                    prop_assert!(pair.changes[aspect as usize].revision <= base || is_confirmed, "{aspect:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_taken_in_is_what_was_there(edits in edits(), other in edits()) {
        let two = Two::new();
        let mut document = MarkerDocument::new([]);
        play(&mut document, &two, &edits);
        let mut elsewhere = document.clone();
        play(&mut elsewhere, &two, &other);
        let contents: Vec<Content> = elsewhere.pairs().iter().map(|pair| pair.content.clone()).collect();
        let before = document.pairs().to_vec();
        let changed = document.take_in(contents.clone(), "changes in the file");
        let now: Vec<Content> = document.pairs().iter().map(|pair| pair.content.clone()).collect();
        prop_assert_eq!(&now, &contents);
        // Pairs that did not change keep their ids.
        for pair in before.iter().filter(|pair| pair.content.name.is_some() && contents.contains(&pair.content)) {
            prop_assert!(document.position(pair.id).is_some());
        }
        if changed {
            document.undo(document.revision()).unwrap();
            prop_assert!(same(document.pairs(), &before));
        }
        prop_assert!(document.pairs().iter().all(|pair| pair.origin != Origin::Mirrored));
    }
}
