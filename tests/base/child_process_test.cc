#include "base/child_process.h"

#include <gmock/gmock.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <thread>

#include "support/temporary_folder.h"

namespace fleetpub::base {
namespace {

using std::chrono::steady_clock;

std::optional<int> Await(ChildProcess& child) {
  const auto end = steady_clock::now() + std::chrono::seconds(10);
  while (!child.Poll() && steady_clock::now() < end) std::this_thread::yield();
  return child.Poll();
}

TEST(ChildProcess, ReadsItsInputAndSaysHowItEnded) {
  const auto child =
      *ChildProcess::Start({.arguments = {"/bin/sh", "-c", "cat; echo no >&2; exit 7"},
                            .input = std::string(200'000, 'x')});
  EXPECT_EQ(Await(*child), 7);
  EXPECT_EQ(child->Output(), std::string(200'000, 'x'));
  EXPECT_EQ(child->Errors(), "no\n");
}

TEST(ChildProcess, HasItsOwnEnvironment) {
  setenv("FLEETPUB_TEST_A", "kept", 1);
  setenv("FLEETPUB_TEST_B", "gone", 1);
  const auto child = *ChildProcess::Start(
      {.arguments = {"/bin/sh", "-c", "echo $FLEETPUB_TEST_A.$FLEETPUB_TEST_B.$FLEETPUB_TEST_C"},
       .input = "",
       .environment = {{"FLEETPUB_TEST_B", ""}, {"FLEETPUB_TEST_C", "new"}}});
  EXPECT_EQ(Await(*child), 0);
  EXPECT_EQ(child->Output(), "kept..new\n");
}

TEST(ChildProcess, EndsWhenNobodyWantsItAnyMore) {
  const auto start = steady_clock::now();
  {
    const auto child = *ChildProcess::Start({.arguments = {"/bin/sleep", "60"}, .input = ""});
    EXPECT_EQ(child->Poll(), std::nullopt);
    child->Terminate();
    EXPECT_EQ(Await(*child), 128 + SIGTERM);
    const auto other = *ChildProcess::Start({.arguments = {"/bin/sleep", "60"}, .input = ""});
  }
  EXPECT_LT(steady_clock::now() - start, std::chrono::seconds(20));
}

// A second SIGTERM would end it at once.
TEST(ChildProcess, IsAskedToEndOnlyOnce) {
  const testing::TemporaryFolder folder;
  const std::string left = (folder.path() / "left").string();
  {
    const auto child = *ChildProcess::Start(
        {.arguments = {"/bin/sh", "-c",
                       "trap 'trap - TERM; echo leaving; sleep 0.3; echo so > " + left +
                           "; exit' TERM; echo ready; while :; do sleep 0.01; done"},
         .input = ""});
    const auto await = [&](std::string_view text) {
      const auto end = steady_clock::now() + std::chrono::seconds(10);
      while (child->Output().find(text) == std::string::npos && steady_clock::now() < end) {
        std::this_thread::yield();
      }
    };
    await("ready");
    child->Terminate();
    await("leaving");
  }
  EXPECT_TRUE(std::filesystem::exists(left));
}

// A server that starts us may have asked the system to forget its children.
TEST(ChildProcess, SaysHowItEndedWhereChildrenWereForgotten) {
  const auto before = std::signal(SIGCHLD, SIG_IGN);
  const auto child = *ChildProcess::Start({.arguments = {"/bin/sh", "-c", "exit 7"}, .input = ""});
  EXPECT_EQ(Await(*child), 7);
  std::signal(SIGCHLD, before);
}

TEST(ChildProcess, ThatCannotBeStartedEndsWithAnError) {
  const auto child = ChildProcess::Start({.arguments = {"/no/such/program"}, .input = ""});
  ASSERT_TRUE(child);
  EXPECT_EQ(Await(**child), 127);
}

}  // namespace
}  // namespace fleetpub::base
