//! A server: what it needs to begin, and how it runs.

use std::{
    io,
    net::{IpAddr, SocketAddr, TcpListener, ToSocketAddrs},
    path::{Path, PathBuf},
    sync::Arc,
};

use mimesh_document::{Diagnostic, Kind, diagnostic};
use mimesh_pipeline::{cache::Cache, input::HelpCommands};
use tempfile::TempDir;

use crate::{
    folders::Folders,
    project::{Context, Opening},
    routes,
    studio::Studio,
    web::{connections, security::Guard},
};

/// What a server begins with.
#[derive(Debug)]
pub struct StudioOptions {
    /// What is opened at once.
    pub start: Option<Start>,
    /// The folder that is looked at first.
    pub folder: PathBuf,
    /// Other folders that may be looked at.
    pub roots: Vec<PathBuf>,
    /// The host to listen on, by name or address.
    pub host: String,
    /// The port to listen on; 0 for any.
    pub port: u16,
    /// Whether stages may run programs of the user's.
    pub allow_commands: bool,
    /// Results of earlier runs.
    pub cache: Option<Cache>,
    /// The commands that the reports of a pipeline name.
    pub help: fn(&Path) -> HelpCommands,
}

/// What is opened at once.
#[derive(Clone, Debug)]
pub enum Start {
    /// A pipeline.
    Pipeline(PathBuf),
    /// A source and a target.
    Pair(PathBuf, PathBuf),
}

/// A server that listens.
#[derive(Debug)]
pub struct Server {
    listener: TcpListener,
    address: SocketAddr,
    guard: Arc<Guard>,
    studio: Arc<Studio>,
    host: String,
    /// Removed at the end.
    scratch: TempDir,
}

impl Server {
    /// Opens what `options` name, and listens.
    ///
    /// # Errors
    ///
    /// What is wrong with the files, and if the server cannot listen.
    pub fn new(options: StudioOptions) -> diagnostic::Result<Self> {
        let StudioOptions { start, folder, roots, host, port, allow_commands, cache, help } = options;
        let scratch = tempfile::Builder::new()
            .prefix("mimesh-studio-")
            .tempdir()
            .map_err(|error| fault("make a folder", &error))?;
        let uploads = scratch.path().join("uploads");
        let own = scratch.path().join("own");
        for folder in [&uploads, &own] {
            std::fs::create_dir(folder).map_err(|error| fault("make a folder", &error))?;
        }
        let uploads = std::fs::canonicalize(&uploads).map_err(|error| fault("find its folder", &error))?;
        // What the user names may lie elsewhere; its folder is open then.
        let started: Vec<PathBuf> = match &start {
            None => vec![],
            Some(Start::Pipeline(file)) => vec![file.clone()],
            Some(Start::Pair(source, target)) => vec![source.clone(), target.clone()],
        };
        let folders_of =
            started.iter().filter_map(|file| std::fs::canonicalize(file).ok()?.parent().map(PathBuf::from));
        let named = |path: PathBuf| {
            let name = std::fs::canonicalize(&path)
                .ok()
                .and_then(|path| Some(path.file_name()?.to_string_lossy().into_owned()));
            (name.unwrap_or_else(|| path.display().to_string()), path)
        };
        let all = std::iter::once(folder).chain(roots.iter().cloned()).chain(folders_of).map(named);
        let folders = Folders::new(all.chain([("Uploads".to_owned(), uploads.clone())]));
        let context = Context { roots, allow_commands, cache, scratch: own, help };
        let studio = Studio::new(context, folders, uploads);
        let studio = Arc::new(studio.map_err(|error| fault("start threads", &io::Error::other(error)))?);
        if let Some(start) = start {
            let opening = match start {
                Start::Pipeline(pipeline) => Opening::Pipeline { pipeline: absolute(pipeline)? },
                Start::Pair(source, target) => Opening::Pair { source: absolute(source)?, target: absolute(target)? },
            };
            studio.open_first(&opening)?;
        }
        let listener = listen(&host, port)?;
        let address = listener.local_addr().map_err(|error| fault("listen", &error))?;
        let guard = Guard::new(address.ip(), address.port(), &host);
        let guard = guard
            .map_err(|error| Diagnostic::new(Kind::Internal, format!("the system gives no random numbers: {error}")))?;
        Ok(Self { listener, address, guard: Arc::new(guard), studio, host, scratch })
    }

    /// The URL with the token, to be opened once.
    pub fn url(&self) -> String {
        let host = match (self.address.ip(), self.host.parse::<IpAddr>()) {
            (IpAddr::V4(address), Ok(_)) => address.to_string(),
            (IpAddr::V6(address), Ok(_)) => format!("[{address}]"),
            (_, Err(_)) => self.host.clone(),
        };
        format!("http://{host}:{}/?token={}", self.address.port(), self.guard.token())
    }

    /// The address that it listens on.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// Whether only this machine can reach it.
    pub fn is_local(&self) -> bool {
        self.address.ip().is_loopback()
    }

    /// The folder for uploads and what else is the server's own. It is removed with the server; who ends the program in another way
    /// removes it before.
    pub fn scratch(&self) -> &Path {
        self.scratch.path()
    }

    /// Serves pages until the program is ended.
    ///
    /// # Errors
    ///
    /// If the system gives no threads, or takes the listener away.
    pub fn run(self) -> diagnostic::Result<()> {
        let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build();
        let runtime = runtime.map_err(|error| fault("start threads", &error))?;
        let done = runtime.block_on(async {
            self.listener.set_nonblocking(true)?;
            let listener = tokio::net::TcpListener::from_std(self.listener)?;
            tokio::spawn(self.studio.clone().attend());
            connections::serve(listener, routes::router(self.studio.clone(), self.guard.clone())).await
        });
        Ok(done.map_err(|error| fault("listen", &error))?)
    }
}

fn absolute(path: PathBuf) -> diagnostic::Result<PathBuf> {
    Ok(std::fs::canonicalize(&path).map_err(|error| mimesh_document::files::unreadable(&path, "read", &error))?)
}

fn listen(host: &str, port: u16) -> diagnostic::Result<TcpListener> {
    let addresses = (host, port).to_socket_addrs().map(Iterator::collect::<Vec<_>>);
    let listener = addresses.and_then(|addresses| TcpListener::bind(&addresses[..]));
    Ok(listener.map_err(|error| {
        let message = format!("cannot listen on {host}, port {port}: {error}");
        Diagnostic::new(Kind::Usage, message).hint("choose another port, or leave it out for any that is free")
    })?)
}

fn fault(action: &str, error: &io::Error) -> Diagnostic {
    Diagnostic::new(Kind::Internal, format!("the server cannot {action}: {error}"))
}
