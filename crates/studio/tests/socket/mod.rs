//! A socket of a test, and what comes over it.

#![allow(dead_code, reason = "each test uses a part of it")]

use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use serde_json::Value;
use tokio_tungstenite::{
    WebSocketStream, client_async,
    tungstenite::{Message, client::IntoClientRequest, handshake::client::Request},
};

use super::common::Client;

/// A socket, and what came over it that nobody has waited for yet: preview and result come in any order.
pub struct Socket {
    pub stream: WebSocketStream<tokio::net::TcpStream>,
    pub unread: Vec<(Value, Vec<u8>)>,
}

/// Opens the socket of `client`'s page.
pub async fn connect(client: &Client) -> Socket {
    let mut request: Request = format!("ws://{}/api/live", client.address).into_client_request().unwrap();
    let headers = request.headers_mut();
    headers.insert("Origin", format!("http://{}", client.address).parse().unwrap());
    headers.insert("Cookie", client.cookie.parse().unwrap());
    let stream = tokio::net::TcpStream::connect(client.address).await.unwrap();
    Socket { stream: client_async(request, stream).await.unwrap().0, unread: vec![] }
}

/// The first unread message for which `is_it` holds: its text, or the header of its frame with the frame.
pub async fn wait(socket: &mut Socket, is_it: impl Fn(&Value) -> bool) -> (Value, Vec<u8>) {
    if let Some(at) = socket.unread.iter().position(|(value, _)| is_it(value)) {
        return socket.unread.remove(at);
    }
    let next = async {
        loop {
            let (value, bytes) = match socket.stream.next().await.expect("an open socket").unwrap() {
                Message::Text(text) => (serde_json::from_str(&text).unwrap(), vec![]),
                Message::Binary(bytes) => {
                    let length = u32::from_le_bytes([bytes[4], bytes[5], bytes[6], bytes[7]]) as usize;
                    (serde_json::from_slice(&bytes[8..8 + length]).unwrap(), bytes.to_vec())
                }
                other => panic!("{other:?}"),
            };
            if is_it(&value) {
                return (value, bytes);
            }
            socket.unread.push((value, bytes));
        }
    };
    let found = tokio::time::timeout(Duration::from_secs(60), next).await;
    found.unwrap_or_else(|_| {
        panic!("no message in time beside {:#?}", socket.unread.iter().map(|m| &m.0).collect::<Vec<_>>())
    })
}

/// Sends `message`.
pub async fn say(socket: &mut Socket, message: Value) {
    socket.stream.send(Message::text(message.to_string())).await.unwrap();
}
