/// The stages of a pipeline that make a method.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// What it is called.
    pub name: &'static str,
    /// Its stages in YAML; `proximity` is added where the target has several components.
    pub stages: &'static str,
    /// Whether it takes part only where the target has several components.
    pub for_components: bool,
}

/// The methods that are measured, simplest first; doing nothing is measured with each of them.
pub const METHODS: [Method; 5] = [
    Method {
        name: "copy_displacement",
        stages: "correspondence: { type: nonrigid_fit }\ntransfer: { type: copy_displacement }\n",
        for_components: false,
    },
    Method {
        name: "gradient",
        stages: "correspondence: { type: nonrigid_fit }\ntransfer: { type: gradient }\n",
        for_components: false,
    },
    Method { name: "biharmonic", stages: "transfer: { type: biharmonic }\n", for_components: false },
    Method {
        name: "multi_component",
        stages: "correspondence: { type: nonrigid_fit }\ntransfer: { type: multi_component }\n",
        for_components: true,
    },
    Method {
        name: "combined",
        stages: "correspondence: { type: nonrigid_fit }\n\
                 transfer: { type: multi_component, initial: { type: biharmonic } }\n",
        for_components: true,
    },
];
