//! Messages in their frames, `Content-Length: N` and N bytes of JSON, from a client that may send anything.

use std::io::{self, BufRead, Read};

use lsp_server::Message;

/// Larger messages are passed over, bytes. A document of [`super::document::LARGEST`] fits however it is escaped.
pub const LARGEST: u64 = 8 << 20;

/// All lines of a header together, bytes.
const LONGEST_HEADER: u64 = 8 << 10;

/// What stood in a frame.
#[derive(Debug)]
pub enum Frame {
    Message(Message),
    /// It cannot be read as a message, for this reason.
    Malformed(String),
    /// So many bytes, which were passed over.
    TooLarge(u64),
}

/// The next frame; `None` at the end of the input.
///
/// # Errors
/// Where the header tells no length, so that nobody can know where the next frame begins, or the input breaks off.
pub fn read(input: &mut impl BufRead) -> io::Result<Option<Frame>> {
    let Some(size) = header(input)? else { return Ok(None) };
    if size > LARGEST {
        let passed = io::copy(&mut input.take(size), &mut io::sink())?;
        return if passed == size { Ok(Some(Frame::TooLarge(size))) } else { Err(broken_off()) };
    }
    // Grows with what comes, not with what is promised.
    let mut bytes = Vec::new();
    input.take(size).read_to_end(&mut bytes)?;
    if (bytes.len() as u64) < size {
        return Err(broken_off());
    }
    Ok(Some(match serde_json::from_slice(&bytes) {
        Ok(message) => Frame::Message(message),
        Err(error) => Frame::Malformed(error.to_string()),
    }))
}

/// The length that a header tells; `None` at the end of the input.
fn header(input: &mut impl BufRead) -> io::Result<Option<u64>> {
    let mut left = LONGEST_HEADER;
    let mut size = None;
    loop {
        let mut line = Vec::new();
        let length = input.take(left).read_until(b'\n', &mut line)? as u64;
        if length == 0 && left == LONGEST_HEADER {
            return Ok(None);
        }
        left -= length;
        let Some(line) = line.strip_suffix(b"\n") else {
            return Err(if left == 0 { invalid("a header without end") } else { broken_off() });
        };
        let line = std::str::from_utf8(line.strip_suffix(b"\r").unwrap_or(line))
            .map_err(|_| invalid("a header that is no text"))?;
        if line.is_empty() {
            return size.map(Some).ok_or_else(|| invalid("a header without `Content-Length`"));
        }
        let (name, value) = line.split_once(':').ok_or_else(|| invalid("a header line without `:`"))?;
        if name.trim().eq_ignore_ascii_case("Content-Length") {
            let told = value.trim().parse().map_err(|_| invalid("a `Content-Length` that is no number"))?;
            if size.replace(told).is_some_and(|before| before != told) {
                return Err(invalid("two `Content-Length` that differ"));
            }
        }
    }
}

fn invalid(what: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, format!("it sent {what}"))
}

fn broken_off() -> io::Error {
    io::Error::new(io::ErrorKind::UnexpectedEof, "it broke off within a message")
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn frames(mut input: &[u8]) -> (Vec<String>, Option<String>) {
        let mut found = Vec::new();
        loop {
            match read(&mut input) {
                Ok(Some(Frame::Message(message))) => found.push(match message {
                    Message::Request(request) => request.method,
                    Message::Notification(notification) => notification.method,
                    Message::Response(_) => "response".into(),
                }),
                Ok(Some(Frame::Malformed(_))) => found.push("malformed".into()),
                Ok(Some(Frame::TooLarge(size))) => found.push(format!("{size}")),
                Ok(None) => return (found, None),
                Err(error) => return (found, Some(error.to_string())),
            }
        }
    }

    #[test]
    fn what_is_framed_well_is_read_whatever_it_holds() {
        let input = "Content-Length: 16\r\n\r\n{\"method\": \"go\"}Content-Type: x\r\ncontent-length:2\n\n[]\
                     Content-Length: 2\r\n\r\n\u{e9}Content-Length: 0\r\n\r\n";
        let (found, error) = frames(input.as_bytes());
        assert_eq!(found, ["go", "malformed", "malformed", "malformed"]);
        assert_eq!(error, None);
    }

    #[test]
    fn what_is_too_large_is_passed_over() {
        let size = LARGEST + 1;
        let mut input = format!("Content-Length: {size}\r\n\r\n").into_bytes();
        input.resize(input.len() + size as usize, b' ');
        input.extend(b"Content-Length: 16\r\n\r\n{\"method\": \"go\"}");
        assert_eq!(frames(&input), (vec![size.to_string(), "go".into()], None));
    }

    #[test]
    fn a_lost_frame_is_an_error_that_says_why() {
        for (input, why) in [
            ("{}", "broke off"),
            ("\r\n", "without `Content-Length`"),
            ("Content-Type: json\r\n\r\n{}", "without `Content-Length`"),
            ("Content-Length 5\r\n\r\n", "without `:`"),
            ("Content-Length: -5\r\n\r\n", "no number"),
            ("Content-Length: 99999999999999999999999\r\n\r\n", "no number"),
            ("Content-Length: 5\r\nContent-Length: 6\r\n\r\n{}", "differ"),
            ("Content-Length: 5\r\n\r\n{}", "broke off"),
            ("Content-Length: 18446744073709551615\r\n\r\n{}", "broke off"),
            ("Content-Length: 5\r\n", "broke off"),
        ] {
            let (found, error) = frames(input.as_bytes());
            assert!(
                found.is_empty() && error.as_ref().is_some_and(|error| error.contains(why)),
                "{input:?}: {error:?}"
            );
        }
        let (_, error) = frames(&vec![b'x'; 1 << 20]);
        assert!(error.unwrap().contains("without end"));
    }

    proptest! {
        #[test]
        fn any_bytes_come_to_an_end(input in proptest::collection::vec(any::<u8>(), 0..2000)) {
            frames(&input);
        }
    }
}
