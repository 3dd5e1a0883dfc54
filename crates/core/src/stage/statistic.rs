/// One number that a [`Metric`](super::Metric) gives of a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistic {
    /// The name in reports and gates, in `snake_case`.
    pub name: &'static str,
    /// What people read in place of its name where it is above a limit, e.g. `lag behind the source's motion`; empty for the name.
    pub title: &'static str,
    /// The unit, e.g. `%`, `degrees`, `count` or `ratio`.
    pub unit: &'static str,
    /// How its values are combined over poses.
    pub aggregate: Aggregate,
    /// The sizes from which a value is doubtful or bad; `None` if no size is a fault.
    pub limits: Option<Limits>,
    /// What it measures, in a sentence of at most 25 words.
    pub meaning: &'static str,
}

/// How the values of a [`Statistic`] are combined over poses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Aggregate {
    /// The mean.
    #[default]
    Mean,
    /// The root of the mean square, for values that are root mean squares themselves.
    RootMeanSquare,
    /// Not at all: the value is the number of a component, a marker or the like.
    None,
}

/// The sizes from which a [`Statistic`] is doubtful or bad; a value counts without its sign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Above this a person should look.
    pub doubtful: f64,
    /// Above this something is wrong.
    pub bad: f64,
}

impl Statistic {
    /// A statistic that is averaged over poses, without limits.
    pub const fn new(name: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        Self { name, title: "", unit, aggregate: Aggregate::Mean, limits: None, meaning }
    }

    /// The number of one thing among many, counted from 0; it has no average.
    pub const fn index(name: &'static str, meaning: &'static str) -> Self {
        Self { aggregate: Aggregate::None, ..Self::new(name, "index", meaning) }
    }

    /// The same, combined over poses by `aggregate`.
    pub const fn with_aggregate(self, aggregate: Aggregate) -> Self {
        Self { aggregate, ..self }
    }

    /// The same, called `title` where it is above a limit: a few words that a reader without this page understands.
    pub const fn with_title(self, title: &'static str) -> Self {
        Self { title, ..self }
    }

    /// The same, doubtful above one size and bad above another.
    pub const fn with_limits(self, doubtful: f64, bad: f64) -> Self {
        Self { limits: Some(Limits { doubtful, bad }), ..self }
    }
}
