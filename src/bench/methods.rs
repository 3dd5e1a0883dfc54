/// The stages of a pipeline that make a method.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// What it is called.
    pub name: &'static str,
    /// Its stages in YAML; `proximity` is added where the target has several components.
    pub stages: &'static str,
    /// The targets that it is for.
    pub targets: Targets,
}

/// Targets by their number of components.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Targets {
    /// Of one.
    Whole,
    /// Of several.
    Parts,
    /// Of any number.
    Any,
}

impl Method {
    /// Whether it takes a target that has several components or not.
    pub fn takes(&self, several: bool) -> bool {
        match self.targets {
            Targets::Whole => !several,
            Targets::Parts => several,
            Targets::Any => true,
        }
    }
}

/// The methods that are measured, simplest first; doing nothing is measured with each of them.
pub const METHODS: [Method; 5] = [
    Method {
        name: "copy_displacement",
        stages: "correspondence: { type: nonrigid_fit }\ntransfer: { type: copy_displacement }\n",
        targets: Targets::Any,
    },
    Method {
        name: "gradient",
        stages: "correspondence: { type: nonrigid_fit }\ntransfer: { type: gradient }\n",
        targets: Targets::Whole,
    },
    Method { name: "biharmonic", stages: "transfer: { type: biharmonic }\n", targets: Targets::Any },
    Method {
        name: "multi_component",
        stages: "correspondence: { type: nonrigid_fit }\ntransfer: { type: multi_component }\n",
        targets: Targets::Parts,
    },
    Method {
        name: "combined",
        stages: "correspondence: { type: nonrigid_fit }\n\
                 transfer: { type: multi_component, initial: { type: biharmonic } }\n",
        targets: Targets::Parts,
    },
];
