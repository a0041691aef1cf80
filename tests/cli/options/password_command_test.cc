#include "cli/options/password_command.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <csignal>
#include <iostream>

#include "support/gone.h"
#include "support/temporary_folder.h"

namespace fleetpub::cli {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// What `sh -c SCRIPT` prints.
Result<std::string> Shell(const std::string& script, milliseconds limit = seconds(20)) {
  return RunPasswordCommand({"sh", "-c", script}, "/f/c.toml:3", limit);
}

std::string Fault(const Result<std::string>& result) {
  if (result) return "no error";
  EXPECT_EQ(result.error().kind, ErrorKind::kLedger);
  EXPECT_THAT(result.error().message, AllOf(HasSubstr("password_command (/f/c.toml:3)"),
                                            HasSubstr("--password-file"), Not(HasSubstr("\n"))));
  return result.error().message;
}

TEST(PasswordCommand, PrintsThePasswordInItsFirstLine) {
  EXPECT_EQ(*Shell("echo hunter2"), "hunter2");
  EXPECT_EQ(*Shell("printf 'no end'"), "no end");
  EXPECT_EQ(*Shell("printf ' of Windows \\r\\nuser: ann\\n'"), " of Windows ");
  EXPECT_EQ(*Shell("printf '\\377\\001\\n'"), "\xff\x01") << "bytes, not text";
  EXPECT_EQ(Shell("head -c 65535 /dev/zero | tr '\\0' x; echo")->size(), 65'535U);
}

TEST(PasswordCommand, IsRunWithoutAShell) {
  EXPECT_EQ(*RunPasswordCommand({"printf", "%s", "$HOME `id` *"}, "c"), "$HOME `id` *");
  EXPECT_THAT(Fault(RunPasswordCommand({"echo hunter2"}, "/f/c.toml:3")),
              HasSubstr("cannot be started"));
}

TEST(PasswordCommand, ThatFailsIsAnErrorWithoutItsOutput) {
  const testing::TemporaryFolder folder;
  EXPECT_THAT(Fault(Shell("echo hunter2; exit 3")),
              AllOf(HasSubstr("exit code 3"), Not(HasSubstr("hunter2"))));
  EXPECT_THAT(Fault(Shell("echo hunter2; kill -9 $$")),
              AllOf(HasSubstr("signal 9"), Not(HasSubstr("hunter2"))));
  EXPECT_THAT(Fault(RunPasswordCommand({"no-such-program"}, "/f/c.toml:3")),
              HasSubstr("no-such-program cannot be started: No such file"));
  EXPECT_THAT(Fault(RunPasswordCommand({folder.Write("data", "x").string()}, "/f/c.toml:3")),
              HasSubstr("cannot be started: Permission denied"));
}

TEST(PasswordCommand, ThatPrintsNoPasswordIsAnError) {
  EXPECT_THAT(Fault(Shell("true")), HasSubstr("empty"));
  EXPECT_THAT(Fault(Shell("echo; echo hunter2")), HasSubstr("empty"));
  EXPECT_THAT(Fault(Shell("printf 'hunter\\0002\\n'")),
              AllOf(HasSubstr("NUL"), Not(HasSubstr("hunter"))));
  EXPECT_THAT(Fault(Shell("head -c 65536 /dev/zero | tr '\\0' x; echo")), HasSubstr("65,535"));
  EXPECT_EQ(*Shell("echo right; printf 'a\\0b'"), "right") << "behind the first line";
}

TEST(PasswordCommand, IsEndedAtItsLimit) {
  for (const char* script : {"exec sleep 60", "exec 1>&-; exec sleep 60", "exec yes"}) {
    const auto start = std::chrono::steady_clock::now();
    EXPECT_THAT(Fault(Shell(script, milliseconds(200))), HasSubstr("within 200 ms")) << script;
    EXPECT_LT(std::chrono::steady_clock::now() - start, seconds(10)) << script;
  }
}

// They would go on, and hold our standard error open.
TEST(PasswordCommand, IsEndedWithWhatItStarted) {
  const testing::TemporaryFolder folder;
  const std::string file = (folder.path() / "pid").string();
  EXPECT_EXIT(
      {
        setsid();  // no terminal, where a program may ask and stays in our process group
        const auto ended = Shell("sleep 60 & echo $! > " + file + "; wait", seconds(1));
        std::cerr << Fault(ended);
        _exit(0);
      },
      ::testing::ExitedWithCode(0), "has not ended");
  EXPECT_TRUE(testing::HasGone(file));
}

// As an agent does that it starts: it inherits the pipe.
TEST(PasswordCommand, IsNotWaitedForByWhatItLeavesBehind) {
  const auto start = std::chrono::steady_clock::now();
  EXPECT_EQ(*Shell("echo hunter2; sleep 9 &"), "hunter2");
  EXPECT_LT(std::chrono::steady_clock::now() - start, seconds(5));
}

TEST(PasswordCommand, SeesNoInput) { EXPECT_EQ(*Shell("cat; echo end"), "end"); }

// Ours ignores them, and so would the program.
TEST(PasswordCommand, HasItsUsualSignals) {
  const auto pipe = std::signal(SIGPIPE, SIG_IGN);
  const auto size = std::signal(SIGXFSZ, SIG_IGN);
  const auto children = std::signal(SIGCHLD, SIG_IGN);
  const auto ignored = Shell("grep SigIgn: /proc/self/status | cut -f2");
  ASSERT_TRUE(ignored) << ignored.error().message;
  constexpr auto kOurs = (1ULL << (SIGPIPE - 1)) | (1ULL << (SIGXFSZ - 1));
  EXPECT_EQ(std::stoull(*ignored, nullptr, 16) & kOurs, 0U);
  std::signal(SIGPIPE, pipe);
  std::signal(SIGXFSZ, size);
  std::signal(SIGCHLD, children);
}

}  // namespace
}  // namespace fleetpub::cli
