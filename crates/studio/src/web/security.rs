//! Who may ask: the token and the cookie, `Host` and `Origin`, and the headers of every answer.
//!
//! The server runs beside everything else that the user's browser shows. Another page may send requests to it, and a name may be
//! made to point at it. So each request must show the cookie, name this server in `Host`, and come from its own page.

use std::{
    net::IpAddr,
    sync::{Arc, LazyLock},
};

use axum::{
    extract::{Request, State},
    http::{HeaderMap, HeaderValue, Method, StatusCode, header},
    middleware::Next,
    response::{IntoResponse, Response},
};
use mimesh_pipeline::{input::ViewScript, page::script_source};
use subtle::ConstantTimeEq;

use crate::error::{ApiError, Code};

/// What scripts and styles the page may use: its own files.
pub const CONTENT_SECURITY_POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; \
    font-src 'self'; connect-src 'self'; worker-src 'self' blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/// What a file that was written may do when it is opened: it is looked at, and runs at most the 3D view of reports that this program has.
///
/// It belongs to no origin, so that it reaches neither this server nor its cookie.
pub fn content_of_results() -> &'static str {
    static POLICY: LazyLock<String> = LazyLock::new(|| {
        let script = ViewScript { text: mimesh_web::report_viewer(), ..ViewScript::default() }.inline();
        let (sandbox, scripts) = match script {
            Some(script) => ("sandbox allow-scripts", script_source(&script)),
            None => ("sandbox", "'none'".into()),
        };
        let looks = "style-src 'unsafe-inline'; img-src data: blob:; font-src data:";
        format!("default-src 'none'; {looks}; script-src {scripts}; {sandbox}; frame-ancestors 'self'")
    });
    &POLICY
}

/// The secrets of a server and the names that it answers to.
#[derive(Debug)]
pub struct Guard {
    token: String,
    cookie: String,
    port: u16,
    /// A name beside addresses and `localhost`, where the server was told to listen on one.
    name: Option<String>,
    /// Whether only this machine can reach the server.
    is_local: bool,
}

impl Guard {
    /// A guard with new secrets for a server at `address`; `name` is the host that it was told to listen on.
    ///
    /// # Errors
    ///
    /// If the system gives no random numbers.
    pub fn new(address: IpAddr, port: u16, name: &str) -> Result<Self, getrandom::Error> {
        let name = Some(name.to_ascii_lowercase()).filter(|name| name.parse::<IpAddr>().is_err());
        Ok(Self { token: secret()?, cookie: secret()?, port, name, is_local: address.is_loopback() })
    }

    /// The token, which the URL holds once.
    pub fn token(&self) -> &str {
        &self.token
    }

    /// The header that sets the cookie.
    fn set_cookie(&self) -> String {
        format!("{}={}; HttpOnly; SameSite=Strict; Path=/", self.cookie_name(), self.cookie)
    }

    /// Servers on other ports of the machine share its cookies, so that each has a name of its own.
    fn cookie_name(&self) -> String {
        format!("mimesh-{}", self.port)
    }

    /// Why a request with these headers is refused.
    fn refusal(&self, method: &Method, headers: &HeaderMap) -> Option<ApiError> {
        let host = one(headers, header::HOST).unwrap_or_default();
        if !self.is_own_host(host) {
            let message = format!("the host `{host}` is not this server");
            return Some(ApiError::new(Code::Forbidden, message).hint("open the URL that the program printed"));
        }
        let is_safe = matches!(*method, Method::GET | Method::HEAD) && !headers.contains_key(header::UPGRADE);
        let is_own = match headers.get(header::ORIGIN) {
            None => is_safe,
            Some(origin) => origin.to_str().ok().and_then(|origin| origin.strip_prefix("http://")) == Some(host),
        };
        (!is_own).then(|| ApiError::new(Code::Forbidden, "the request comes from another page"))
    }

    /// Whether `host` names this server: by address or as `localhost`, which nobody else can make point here, or by its own name.
    fn is_own_host(&self, host: &str) -> bool {
        let (name, port) = match host.rsplit_once(':') {
            Some((name, port)) if !port.contains(']') => (name, port.parse::<u16>().ok()),
            _ => (host, Some(80)),
        };
        let literal = name.strip_prefix('[').and_then(|name| name.strip_suffix(']')).unwrap_or(name);
        let is_name = match literal.parse::<IpAddr>() {
            Ok(address) => address.is_loopback() || !self.is_local,
            Err(_) => name == "localhost" || self.name.as_deref().is_some_and(|own| name.eq_ignore_ascii_case(own)),
        };
        is_name && port == Some(self.port)
    }

    fn has_cookie(&self, headers: &HeaderMap) -> bool {
        let name = self.cookie_name();
        let all = headers.get_all(header::COOKIE).iter().filter_map(|cookies| cookies.to_str().ok());
        let pairs = all.flat_map(|cookies| cookies.split(';')).filter_map(|pair| pair.trim().split_once('='));
        pairs.filter(|(key, _)| *key == name).any(|(_, value)| same(value, &self.cookie))
    }

    /// Whether the query of the first visit holds the token; `None` if it holds none.
    fn shown_token(&self, request: &Request) -> Option<bool> {
        if request.uri().path() != "/" || request.method() != Method::GET {
            return None;
        }
        let pairs = request.uri().query()?.split('&').filter_map(|pair| pair.split_once('='));
        let token = pairs.filter(|(key, _)| *key == "token").map(|(_, value)| value).next()?;
        Some(same(token, &self.token))
    }
}

/// Lets a request pass, or refuses it; every answer gets the headers that bind the browser.
pub async fn guard(State(guard): State<Arc<Guard>>, request: Request, next: Next) -> Response {
    let mut response = match guard.refusal(request.method(), request.headers()) {
        Some(refusal) => refusal.into_response(),
        None => match guard.shown_token(&request) {
            Some(true) => {
                let headers = [(header::SET_COOKIE, guard.set_cookie()), (header::LOCATION, "/".into())];
                (StatusCode::SEE_OTHER, headers).into_response()
            }
            Some(false) => ApiError::new(Code::Forbidden, "the token is not that of this server")
                .hint("open the URL that the program printed last")
                .into_response(),
            None if guard.has_cookie(request.headers()) => next.run(request).await,
            None => ApiError::new(Code::Unauthorized, "the cookie of this server is missing")
                .hint("open the URL that the program printed; it holds the token")
                .into_response(),
        },
    };
    let headers = response.headers_mut();
    let fixed = [
        (header::CONTENT_SECURITY_POLICY, CONTENT_SECURITY_POLICY),
        (header::CACHE_CONTROL, "no-store"),
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::X_FRAME_OPTIONS, "SAMEORIGIN"),
    ];
    for (name, value) in fixed {
        headers.entry(name).or_insert(HeaderValue::from_static(value));
    }
    for name in ["cross-origin-opener-policy", "cross-origin-resource-policy"] {
        headers.insert(name, HeaderValue::from_static("same-origin"));
    }
    response
}

/// The only value of a header; none if there are several, of which a proxy may have read another.
fn one(headers: &HeaderMap, name: header::HeaderName) -> Option<&str> {
    let mut values = headers.get_all(name).iter();
    let first = values.next()?.to_str().ok()?;
    values.next().is_none().then_some(first)
}

/// Compares in a time that does not tell where texts differ.
fn same(given: &str, secret: &str) -> bool {
    given.as_bytes().ct_eq(secret.as_bytes()).into()
}

/// 32 random bytes in hexadecimal.
fn secret() -> Result<String, getrandom::Error> {
    let mut bytes = [0; 32];
    getrandom::fill(&mut bytes)?;
    Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect())
}

#[cfg(test)]
mod tests {
    use std::net::Ipv4Addr;

    use super::*;

    #[test]
    fn hosts_that_others_could_make_point_here_are_refused() {
        let local = Guard::new(Ipv4Addr::LOCALHOST.into(), 8000, "127.0.0.1").unwrap();
        for host in ["127.0.0.1:8000", "localhost:8000", "[::1]:8000"] {
            assert!(local.is_own_host(host), "{host}");
        }
        for host in
            ["", "evil.example:8000", "127.0.0.1", "127.0.0.1:8001", "localhost.evil.example:8000", "10.0.0.1:8000"]
        {
            assert!(!local.is_own_host(host), "{host}");
        }
        let open = Guard::new(Ipv4Addr::UNSPECIFIED.into(), 80, "studio.lan").unwrap();
        for host in ["10.0.0.1", "studio.lan", "STUDIO.lan:80", "localhost"] {
            assert!(open.is_own_host(host), "{host}");
        }
        assert!(!open.is_own_host("other.lan"));
    }

    #[test]
    fn results_run_no_script_but_the_view_of_reports() {
        let policy = content_of_results();
        assert!(
            policy.contains("default-src 'none'")
                && policy.contains("; sandbox")
                && !policy.contains("allow-same-origin")
        );
        let scripts = policy.split("script-src ").nth(1).unwrap().split(';').next().unwrap();
        assert!(scripts == "'none'" || scripts.starts_with("'sha256-") && !scripts.contains(' '), "{policy}");
    }

    #[test]
    fn secrets_are_long_and_differ() {
        let guard = Guard::new(Ipv4Addr::LOCALHOST.into(), 1, "127.0.0.1").unwrap();
        assert!(guard.token.len() == 64 && guard.token != guard.cookie);
    }
}
