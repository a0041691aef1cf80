// Builders and processes for the ledger's tests.
#pragma once

#include <fcntl.h>
#include <grp.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ledger/sqlite/sqlite_ledger.h"
#include "support/temporary_folder.h"

namespace fleetpub::ledger {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

inline SqliteOptions OptionsFor(const std::filesystem::path& path) {
  SqliteOptions options;
  options.path = path;
  options.user = "operator";
  options.host = "control-room";
  options.profile = "hall-3";
  return options;
}

inline std::string MakeTopic(int robot) {
  return "uagv/v2/KIT/" + std::to_string(robot) + "/instantActions";
}

inline Draft DraftFor(int robot = 1) {
  Draft draft;
  draft.topic = MakeTopic(robot);
  draft.target = "KIT/" + std::to_string(robot);
  draft.protocol = "VDA5050";
  draft.version = "2.1.0";
  draft.broker = "mqtt://localhost:1883";
  draft.actions = {{"startPause", "a-1"}};
  draft.before_id = R"({"headerId":)";
  draft.after_id = "}";
  return draft;
}

inline Draft DraftWithId(std::uint32_t header_id) {
  Draft draft = DraftFor();
  draft.header_id = header_id;
  return draft;
}

/// Opens, or ends the test.
inline std::unique_ptr<Ledger> MustOpen(const SqliteOptions& options,
                                        OpenMode mode = OpenMode::kCreate) {
  auto ledger = OpenSqlite(options, mode);
  if (!ledger) throw std::runtime_error(ledger.error().message + " " + ledger.error().detail);
  return std::move(*ledger);
}

inline std::unique_ptr<Ledger> MustOpen(const std::filesystem::path& path,
                                        OpenMode mode = OpenMode::kCreate) {
  return MustOpen(OptionsFor(path), mode);
}

inline Reservation MustReserve(Ledger& ledger, const Draft& draft = DraftFor()) {
  auto reserved = ledger.Reserve(std::span(&draft, 1));
  if (!reserved) throw std::runtime_error(reserved.error().message + " " + reserved.error().detail);
  return reserved->front();
}

inline void MustRecord(Ledger& ledger, const StatusUpdate& outcome) {
  const Status recorded = ledger.RecordOutcomes(std::span(&outcome, 1));
  if (!recorded) throw std::runtime_error(recorded.error().message);
}

/// "" when it opened.
inline std::string ErrorOfOpening(const std::filesystem::path& path,
                                  OpenMode mode = OpenMode::kCreate) {
  const auto ledger = OpenSqlite(OptionsFor(path), mode);
  if (ledger) return "";
  EXPECT_EQ(ledger.error().kind, ErrorKind::kLedger);
  EXPECT_EQ(ledger.error().message.find('\n'), std::string::npos);
  return ledger.error().message;
}

inline Deadline In(milliseconds wait) { return steady_clock::now() + wait; }

/// Starts a process that runs this and ends. The caller waits for it.
inline pid_t StartProcess(const std::function<void()>& work) {
  const pid_t child = fork();
  if (child != 0) return child;
  try {
    work();
  } catch (const std::exception& error) {
    fprintf(stderr, "child: %s\n", error.what());
    _exit(1);
  }
  _exit(0);
}

inline int WaitFor(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return status;
}

/// In memory where that is possible: thousands of commits would otherwise take as long as the disk
/// of the day pleases.
inline std::unique_ptr<testing::TemporaryFolder> FastFolder() {
  const char* before = getenv("TMPDIR");
  const std::string kept = before == nullptr ? "" : before;
  if (access("/dev/shm", W_OK) == 0) setenv("TMPDIR", "/dev/shm", 1);
  auto folder = std::make_unique<testing::TemporaryFolder>();
  if (before == nullptr) {
    unsetenv("TMPDIR");
  } else {
    setenv("TMPDIR", kept.c_str(), 1);
  }
  return folder;
}

/// What `work` returns in a process of its own.
inline std::string InProcess(const std::function<std::string()>& work) {
  int ends[2] = {};
  if (pipe(ends) != 0) throw std::runtime_error("pipe");
  const pid_t child = StartProcess([&] {
    const std::string text = work();
    if (write(ends[1], text.data(), text.size()) < 0) throw std::runtime_error("write");
  });
  close(ends[1]);
  std::string result(4096, '\0');
  const ssize_t size = read(ends[0], result.data(), result.size());
  close(ends[0]);
  result.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
  return WaitFor(child) == 0 ? result : "the process failed";
}

/// The same as a user who is not root: permissions mean nothing to root.
inline std::string AsOrdinaryUser(const std::function<std::string()>& work) {
  return InProcess([&]() -> std::string {
    constexpr unsigned kNobody = 65534;
    if (geteuid() == 0 &&
        (setgroups(0, nullptr) != 0 || setgid(kNobody) != 0 || setuid(kNobody) != 0)) {
      return "cannot become an ordinary user";
    }
    return work();
  });
}

}  // namespace fleetpub::ledger
