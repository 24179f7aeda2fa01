//! The mediator as a process of its own.

use std::ffi::OsString;
use std::io;
use std::path::PathBuf;
use std::process::ExitStatus;

use mediator::runtime::{Answer, Folder, Question, ask};
use sim::rt::monotonic_ns;

use super::child::Process;
use super::usage::Usage;

/// Hidden subcommand by which this program becomes a mediator.
pub const SUBCOMMAND: &str = "__mediator";

/// What a mediator is started with.
#[derive(Clone, Debug)]
pub struct MediatorSetup {
    /// The program that becomes the mediator: the rig's own.
    pub program: PathBuf,
    /// Site file.
    pub site_file: PathBuf,
    /// The site's name.
    pub site: String,
    /// Where grants are recorded.
    pub journal: PathBuf,
    /// First part of all keys.
    pub key_prefix: String,
    /// Where it listens for robots.
    pub listen: String,
    /// Where the listener is, unless that comes to it.
    pub connect: Option<String>,
    /// The site's keys; none: no certificates.
    pub keys: Option<PathBuf>,
    /// Folder for its control socket.
    pub runtime: PathBuf,
    /// Where its log goes.
    pub log: PathBuf,
}

/// A mediator, running or not.
#[derive(Debug)]
pub struct MediatorProcess {
    setup: MediatorSetup,
    process: Option<Process>,
    /// Memory and processor time of the last process.
    pub usage: Usage,
    /// When its processes began and ended.
    spans_ns: Vec<(u64, Option<u64>)>,
}

impl MediatorProcess {
    /// Starts it.
    ///
    /// # Errors
    /// The operating system's.
    pub fn start(setup: MediatorSetup) -> io::Result<Self> {
        std::fs::File::create(&setup.log)?;
        let mut mediator = Self {
            setup,
            process: None,
            usage: Usage::of(0),
            spans_ns: Vec::new(),
        };
        mediator.start_again()?;
        Ok(mediator)
    }

    /// Starts it again unless it runs, with the same journal and endpoints.
    ///
    /// # Errors
    /// The operating system's.
    pub fn start_again(&mut self) -> io::Result<()> {
        if self
            .process
            .as_mut()
            .is_some_and(|own| own.poll().is_none())
        {
            return Ok(());
        }
        let setup = &self.setup;
        let mut arguments: Vec<OsString> = [SUBCOMMAND, "run", "--first-start"]
            .map(OsString::from)
            .to_vec();
        let mut add = |key: &str, value: OsString| arguments.extend([OsString::from(key), value]);
        add("--site", setup.site_file.clone().into());
        add("--journal", setup.journal.clone().into());
        add("--key-prefix", setup.key_prefix.clone().into());
        add("--listen", setup.listen.clone().into());
        if let Some(connect) = &setup.connect {
            add("--connect", connect.into());
        }
        if let Some(keys) = &setup.keys {
            add("--keys", keys.into());
        }
        add("--runtime", setup.runtime.clone().into());
        let process = Process::start(&setup.program, &arguments, &[], &setup.log)?;
        self.usage = Usage::of(process.id());
        self.process = Some(process);
        self.spans_ns.push((monotonic_ns(), None));
        Ok(())
    }

    /// Kills it.
    pub fn kill(&mut self) {
        if let Some(mut process) = self.process.take() {
            process.kill();
            self.note_end();
        }
    }

    /// Asks it to stop, and waits until it has; none when it did not run.
    pub fn stop(&mut self) -> Option<ExitStatus> {
        let status = self.process.take()?.stop();
        self.note_end();
        Some(status)
    }

    /// Its exit status, when it has ended by itself.
    pub fn poll(&mut self) -> Option<ExitStatus> {
        let status = self.process.as_mut()?.poll()?;
        self.note_end();
        Some(status)
    }

    /// Its process id, while it runs.
    #[must_use]
    pub fn id(&self) -> Option<u32> {
        self.process.as_ref().map(Process::id)
    }

    /// When its processes began and ended; none: it still runs.
    #[must_use]
    pub fn spans_ns(&self) -> &[(u64, Option<u64>)] {
        &self.spans_ns
    }

    /// Its control socket.
    ///
    /// # Errors
    /// A sentence when its folder cannot be made.
    pub fn socket(&self) -> Result<PathBuf, String> {
        let folder = Folder::new(Some(self.setup.runtime.clone()), &self.setup.site)?;
        Ok(folder.socket())
    }

    /// What an operator does with `mediator clear AREA --taken-away`. Returns what it answered.
    ///
    /// # Errors
    /// Why it refused or did not answer.
    pub fn clear(&self, area: &str) -> Result<String, String> {
        let question = Question::Clear {
            area: area.to_owned(),
            taken_away: true,
        };
        match ask(&self.socket()?, &question)? {
            Answer::Done(text) => Ok(text),
            Answer::Refused(why) => Err(why),
            answer => Err(format!("unexpected answer {answer:?}")),
        }
    }

    /// The last lines of its log.
    #[must_use]
    pub fn log_tail(&self, lines: usize) -> String {
        self.process
            .as_ref()
            .map_or(String::new(), |process| process.log_tail(lines))
    }

    fn note_end(&mut self) {
        if let Some((_, end @ None)) = self.spans_ns.last_mut() {
            *end = Some(monotonic_ns());
        }
    }
}
