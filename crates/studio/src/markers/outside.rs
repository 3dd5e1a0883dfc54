//! Taking in what somebody else made of the file, or a stage of the proposals.

use std::{collections::HashSet, sync::Arc};

use super::{
    document::MarkerDocument,
    pair::{Aspect, Change, Content, Origin, Pair, Status},
};

impl MarkerDocument {
    /// Makes `contents` the pairs of the document, as one step of undo; pairs that are recognised keep their ids. Whether anything has
    /// changed.
    ///
    /// A pair is recognised by its name, else by both of its points, else by one of them.
    pub fn take_in(&mut self, contents: Vec<Content>, title: &str) -> bool {
        let before = self.pairs.clone();
        let change = Change { revision: self.revision + 1, client: "".into() };
        let matched = matches(&contents, &before);
        self.pairs = contents
            .into_iter()
            .zip(matched)
            .map(|(content, pair)| match pair {
                Some(pair) => changed(pair, content, &change),
                None => self.new_pair(content, Origin::File, &change),
            })
            .collect();
        self.commit(before, title.into())
    }

    /// Replaces all pairs that are still proposed by `proposals`, as one step of undo. Whether anything has changed.
    ///
    /// Proposals of the name of a pair that stays get none. Those with a point of such a pair are left out: a person may have clicked it
    /// while they were sought.
    pub fn propose(&mut self, proposals: Vec<Content>) -> bool {
        let before = self.pairs.clone();
        let change = Change { revision: self.revision + 1, client: "".into() };
        self.pairs.retain(|pair| pair.content.status != Status::Proposed);
        let kept = self.pairs.clone();
        let mut free = free_numbers(&kept);
        let is_taken = |proposal: &Content| kept.iter().any(|pair| shares_point(proposal, &pair.content));
        for mut content in proposals.into_iter().filter(|proposal| !is_taken(proposal)) {
            if content.name.is_some() && self.pairs.iter().any(|pair| pair.content.name == content.name) {
                content.name = None;
            }
            // The same proposal as before is the same pair.
            let known = before
                .iter()
                .find(|pair| pair.content.points == content.points && pair.content.status == Status::Proposed);
            let known = known.filter(|pair| self.position(pair.id).is_none()).cloned();
            let pair = match known {
                Some(pair) => changed(pair, content, &change),
                None => self.new_pair(content, Origin::Proposed, &change),
            };
            // Proposals that go leave no gaps.
            let number = free.next().unwrap_or(pair.number);
            self.pairs.push(if pair.number == number { pair } else { Arc::new(Pair { number, ..(*pair).clone() }) });
        }
        self.next_number = self.largest_number() + 1;
        self.commit(before, "propose".into())
    }
}

/// The numbers that none of `pairs` has, from 1.
fn free_numbers(pairs: &[Arc<Pair>]) -> impl Iterator<Item = usize> + use<> {
    let taken: HashSet<usize> = pairs.iter().map(|pair| pair.number).collect();
    (1..).filter(move |number| !taken.contains(number))
}

/// Whether two pairs have the same point of a side.
fn shares_point(a: &Content, b: &Content) -> bool {
    (0..2).any(|k| a.points[k].is_some() && a.points[k] == b.points[k])
}

/// For each of `contents` the pair that it is.
fn matches(contents: &[Content], pairs: &[Arc<Pair>]) -> Vec<Option<Arc<Pair>>> {
    let mut matched: Vec<Option<Arc<Pair>>> = vec![None; contents.len()];
    let mut is_free = vec![true; pairs.len()];
    let rules: [fn(&Content, &Content) -> bool; 4] =
        [|a, b| a == b, |a, b| a.name.is_some() && a.name == b.name, |a, b| a.points == b.points, shares_point];
    for is_same in rules {
        for (content, found) in contents.iter().zip(&mut matched).filter(|(_, found)| found.is_none()) {
            let at = (0..pairs.len()).find(|&i| is_free[i] && is_same(content, &pairs[i].content));
            if let Some(i) = at {
                is_free[i] = false;
                *found = Some(pairs[i].clone());
            }
        }
    }
    matched
}

fn changed(pair: Arc<Pair>, content: Content, change: &Change) -> Arc<Pair> {
    let aspects: Vec<Aspect> = pair.content.differences(&content);
    if aspects.is_empty() {
        return pair;
    }
    let mut changes = pair.changes.clone();
    aspects.into_iter().for_each(|aspect| changes[aspect as usize] = change.clone());
    Arc::new(Pair { content, changes, ..(*pair).clone() })
}
