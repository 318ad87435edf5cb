//! CPU time of one thread, which other work on the machine does not lengthen.

/// CPU seconds of this thread so far, where the system says; otherwise the clock.
pub fn thread_cpu_s() -> f64 {
    let nanoseconds = std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|text| text.split_whitespace().next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(
        || std::time::UNIX_EPOCH.elapsed().map_or(f64::NAN, |time| time.as_secs_f64()),
        |nanoseconds| nanoseconds * 1e-9,
    )
}
