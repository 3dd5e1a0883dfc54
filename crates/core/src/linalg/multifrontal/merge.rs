//! Merges fronts of few columns, which cost more to put together than to eliminate.

use std::cmp::Reverse;

use faer::sparse::linalg::cholesky::supernodal::SymbolicSupernodalCholesky;

/// A front may take in one below it if it has so many columns at most and zeros are no more than this part of its entries.
const RELAXED: [(usize, f64); 4] = [(4, 0.9), (12, 0.5), (32, 0.2), (128, 0.06)];

/// What a front costs besides arithmetic, in multiplications.
const OVERHEAD: f64 = 500.0;

/// Columns that are eliminated together, in the numbers of the ordering.
pub(super) struct Node {
    pub columns: Vec<u32>,
    /// Rows that they act on besides themselves.
    pub below: Vec<u32>,
    pub parent: Option<usize>,
    pub children: Vec<usize>,
    /// Multiplications, with those of all nodes below.
    pub work: f64,
    zeros: usize,
    /// Whether its parent has taken it in.
    merged: bool,
}

/// The nodes of a forest, children before parents, of which some are no longer there.
pub(super) struct Forest {
    pub nodes: Vec<Node>,
    pub roots: Vec<usize>,
    /// Work of all nodes.
    pub work: f64,
}

impl Forest {
    pub fn new(symbolic: &SymbolicSupernodalCholesky<usize>) -> Self {
        let mut nodes = nodes(symbolic);
        (0..nodes.len()).for_each(|s| merge_children(&mut nodes, s));
        for s in 0..nodes.len() {
            if !nodes[s].merged {
                let (columns, below) = (nodes[s].columns.len() as f64, nodes[s].below.len() as f64);
                let own = columns * (below * (below + columns) + columns * columns / 3.0) + OVERHEAD;
                nodes[s].work = own + nodes[s].children.iter().map(|&c| nodes[c].work).sum::<f64>();
            }
        }
        let roots: Vec<usize> = (0..nodes.len()).filter(|&s| !nodes[s].merged && nodes[s].parent.is_none()).collect();
        let work = roots.iter().map(|&s| nodes[s].work).sum();
        Self { nodes, roots, work }
    }
}

fn nodes(symbolic: &SymbolicSupernodalCholesky<usize>) -> Vec<Node> {
    let (begin, end) = (symbolic.supernode_begin(), symbolic.supernode_end());
    let count = symbolic.n_supernodes();
    let mut of_column = vec![0; symbolic.ncols()];
    (0..count).for_each(|s| of_column[begin[s]..end[s]].fill(s));
    let node = |s: usize| {
        let below: Vec<u32> = symbolic.supernode(s).pattern().iter().map(|&r| r as u32).collect();
        let parent = below.first().map(|&r| of_column[r as usize]);
        let columns = (begin[s] as u32..end[s] as u32).collect();
        Node { columns, below, parent, children: vec![], work: 0.0, zeros: 0, merged: false }
    };
    let mut nodes: Vec<Node> = (0..count).map(node).collect();
    for s in 0..count {
        if let Some(parent) = nodes[s].parent {
            nodes[parent].children.push(s);
        }
    }
    nodes
}

/// Takes in children of node `s` that bring few zeros; their own children have been looked at before.
fn merge_children(nodes: &mut [Node], s: usize) {
    let mut children = std::mem::take(&mut nodes[s].children);
    children.sort_by_key(|&c| (Reverse(nodes[c].below.len()), c));
    let mut kept = Vec::with_capacity(children.len());
    for c in children {
        let (columns, below) = (nodes[s].columns.len(), nodes[s].below.len());
        let added = nodes[c].columns.len();
        let all = columns + added;
        let zeros = nodes[s].zeros + nodes[c].zeros + added * (columns + below - nodes[c].below.len());
        let entries = (all * (all + 1) / 2 + all * below) as f64;
        if RELAXED.iter().any(|&(most, share)| all <= most && zeros as f64 <= share * entries) {
            let mut merged = std::mem::take(&mut nodes[c].columns);
            merged.append(&mut nodes[s].columns);
            nodes[s].columns = merged;
            nodes[s].zeros = zeros;
            nodes[c].merged = true;
            let grandchildren = std::mem::take(&mut nodes[c].children);
            grandchildren.iter().for_each(|&g| nodes[g].parent = Some(s));
            kept.extend(grandchildren);
        } else {
            kept.push(c);
        }
    }
    nodes[s].children = kept;
}
