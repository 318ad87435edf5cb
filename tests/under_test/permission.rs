//! What may run: nothing that its user has not allowed, and what is allowed until it is something else.

use super::*;

pub fn nothing_runs_that_is_not_allowed() -> Outcome {
    let folder = in_folder(&scenario("touch=ran", ""));
    let (path, ran) = (folder.path(), folder.path().join("ran"));
    for arguments in [
        &["check", "meet.scn"][..],
        &["list", "meet.scn"],
        &["fmt", "--check", "meet.scn"],
        &["convert", "meet.scn"],
        &["models", "own", "meet.scn"],
        &["meet.scn", "--list"],
        &["allow", "meet.scn"],
        &["allow", "--revoke", "meet.scn"],
    ] {
        let said = run(path, arguments);
        expect(!ran.exists(), || format!("{arguments:?} ran it: {}", said.text))?;
    }
    for arguments in [
        &["meet.scn"][..],
        &["meet.scn", "--allow-run=other"],
        &["replay", "meet/meet/later=0s/rep=1", "meet.scn"],
        &["why", "meet/meet/later=0s/rep=1", "meet.scn"],
        &["baseline", "save", "meet.scn"],
        &["compare", "meet.scn", "meet.scn"],
    ] {
        let said = run(path, arguments);
        expect_all(&said, 3, &["E1105", "`own` wants to run", "scenario-runner allow meet.scn"])?;
        expect(!ran.exists(), || format!("{arguments:?} ran it: {}", said.text))?;
    }
    expect_all(&run(path, &["meet.scn", "--allow-run=own"]), 0, &[])?;
    expect(ran.exists(), || "it did not run".to_string())
}

pub fn what_is_allowed_runs_until_it_is_another() -> Outcome {
    let folder = in_folder(&scenario("touch=ran", ""));
    let path = folder.path();
    expect_all(&run(path, &["allow", "meet.scn"]), 0, &["own (meet.scn:1) may run", "\"touch=ran\""])?;
    expect_all(&run(path, &["meet.scn"]), 0, &[])?;
    expect_all(&run(path, &["allow", "--list"]), 0, &["own ", "meet.scn"])?;
    // Limits and parameters need no new permission, what runs does.
    fs::write(path.join("meet.scn"), scenario("touch=ran", "answers within 5 s"))?;
    expect_all(&run(path, &["meet.scn"]), 0, &[])?;
    fs::write(path.join("meet.scn"), scenario("touch=other", ""))?;
    expect_all(&run(path, &["meet.scn"]), 3, &["E1105"])?;
    fs::write(path.join("meet.scn"), scenario("touch=ran", ""))?;
    // Of another place it is another file.
    fs::create_dir(path.join("copy"))?;
    fs::copy(path.join("meet.scn"), path.join("copy/meet.scn"))?;
    expect_all(&run(path, &["copy/meet.scn"]), 3, &["E1105"])?;
    // A project cannot allow itself.
    let said = runner(path, &["meet.scn"])
        .env("XDG_CONFIG_HOME", "config")
        .env("HOME", path.join("home"))
        .output()?;
    expect(said.status.code() == Some(3), || String::from_utf8_lossy(&said.stderr).into_owned())?;
    let said = runner(path, &["copy/meet.scn"]).env("SCENARIO_RUNNER_ALLOW_RUN", "other, own").output()?;
    expect(said.status.code() == Some(0), || String::from_utf8_lossy(&said.stderr).into_owned())?;
    expect_all(&run(path, &["allow", "--revoke", "meet.scn"]), 0, &["took back 1"])?;
    expect_all(&run(path, &["meet.scn"]), 3, &["E1105"])?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(path.join("meet.scn"), fs::Permissions::from_mode(0o646))?;
        expect_all(&run(path, &["allow", "meet.scn"]), 2, &["everybody may write"])?;
    }
    Ok(())
}
