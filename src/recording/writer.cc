#include "recording/writer.h"

#include <fmt/format.h>

#include <condition_variable>
#include <csignal>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "recording/bytes.h"
#include "recording/file.h"
#include "recording/reader.h"

namespace fleetpub::recording {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kLongestWait{100};     // of a line, until it is written
constexpr milliseconds kFlushInterval{1000};  // of compressed data, which costs some of it
constexpr std::size_t kWriteAtOnce = std::size_t{256} * 1024;

// One file after the other.
class Files {
 public:
  explicit Files(WriterOptions options) : options_(std::move(options)) {}

  Status Open() {
    const bool rotates = options_.rotation.time || options_.rotation.bytes;
    options_.head.part = ++written_.files;
    auto file =
        OutputFile::Create(rotates ? PartPath(options_.path, written_.files) : options_.path);
    if (!file) return Fail(std::move(file.error()));
    file_ = *std::move(file);
    begun_ = flushed_ = steady_clock::now();
    count_ = 0;
    sum_.Restart();
    auto ok = Store(ToLine(options_.head));
    return ok ? file_->Flush() : ok;
  }

  Status Write(std::string_view lines, std::uint64_t messages) {
    if (auto ok = lines.empty() ? Status() : Store(lines); !ok) return ok;
    count_ += messages;
    written_.messages += messages;
    const auto now = steady_clock::now();
    const auto& [time, bytes] = options_.rotation;
    const bool is_due = (time && now >= begun_ + *time) || (bytes && file_->size() >= *bytes);
    if (is_due) {
      auto ok = Close();
      return ok ? Open() : ok;
    }
    if (now < flushed_ + kFlushInterval) return {};
    flushed_ = now;
    return file_->Flush();
  }

  Status Close() {
    const Foot foot{
        .ended = base::WallTime::clock::now(), .count = count_, .sha256 = sum_.Digest()};
    auto ok = file_->Write(ToLine(foot));
    if (ok) ok = file_->Close();
    written_.bytes += file_->size();
    return ok;
  }

  [[nodiscard]] const Written& written() const { return written_; }
  [[nodiscard]] std::size_t most_waiting() const { return options_.most_waiting; }

 private:
  Status Store(std::string_view lines) {
    sum_.Add(lines);
    return file_->Write(lines);
  }

  WriterOptions options_;
  std::optional<OutputFile> file_;
  steady_clock::time_point begun_;
  steady_clock::time_point flushed_;
  std::uint64_t count_ = 0;  // messages of this file
  Sha256 sum_;
  Written written_;
};

}  // namespace

class Writer::Job {
 public:
  explicit Job(WriterOptions options) : files_(std::move(options)) {}

  Status Start() {
    if (auto ok = files_.Open(); !ok) return ok;
    // Signals are for the thread that waits for them.
    sigset_t all;
    sigset_t before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    thread_ = std::thread([this] { Run(); });
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
    return {};
  }

  Status Add(std::string_view line, const Moment& when, bool is_message) {
    const std::lock_guard lock(mutex_);
    if (trouble_) return Fail(*trouble_);
    if (is_message && waiting_.size() + line.size() > files_.most_waiting()) {
      ++lost_now_;
      return {};
    }
    TellLoss(when);
    waiting_ += line;
    if (is_message) ++messages_;
    if (waiting_.size() >= kWriteAtOnce) wake_.notify_one();
    return {};
  }

  Result<Written> End() {
    {
      const std::lock_guard lock(mutex_);
      TellLoss({.t = last_, .at = base::WallTime::clock::now()});
      is_ending_ = true;
    }
    wake_.notify_one();
    thread_.join();
    if (!trouble_) {
      if (auto ok = files_.Close(); !ok) trouble_ = ok.error();
    }
    if (trouble_) return Fail(*trouble_);
    Written written = files_.written();
    written.lost = lost_;
    return written;
  }

  [[nodiscard]] bool is_running() const { return thread_.joinable(); }

 private:
  void TellLoss(const Moment& when) {
    last_ = when.t;
    if (lost_now_ == 0) return;
    Event event;
    static_cast<Moment&>(event) = when;
    event.kind = "overflow";
    event.text = "they came faster than they could be written";
    event.messages = std::exchange(lost_now_, 0);
    lost_ += event.messages;
    waiting_ += ToLine(event);
  }

  void Run() {
    std::string lines;
    for (bool goes_on = true; goes_on;) {
      std::uint64_t messages = 0;
      {
        std::unique_lock lock(mutex_);
        wake_.wait_for(lock, kLongestWait,
                       [this] { return is_ending_ || waiting_.size() >= kWriteAtOnce; });
        goes_on = !is_ending_;
        lines.clear();
        lines.swap(waiting_);
        messages = std::exchange(messages_, 0);
      }
      if (auto ok = files_.Write(lines, messages); !ok) {
        const std::lock_guard lock(mutex_);
        trouble_ = std::move(ok.error());
        return;
      }
    }
  }

  Files files_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::string waiting_;
  std::uint64_t messages_ = 0;  // of waiting_
  std::uint64_t lost_now_ = 0;  // since the last line
  std::uint64_t lost_ = 0;
  std::chrono::microseconds last_{0};
  bool is_ending_ = false;
  std::optional<Error> trouble_;
  std::thread thread_;
};

Writer::Writer(std::unique_ptr<Job> job) : job_(std::move(job)) {}

Writer::~Writer() {
  if (job_->is_running()) static_cast<void>(End());
}

Result<std::unique_ptr<Writer>> Writer::Open(WriterOptions options) {
  auto job = std::make_unique<Job>(std::move(options));
  if (auto ok = job->Start(); !ok) return Fail(std::move(ok.error()));
  return std::unique_ptr<Writer>(new Writer(std::move(job)));
}

Status Writer::Add(const Message& message) { return job_->Add(ToLine(message), message, true); }
Status Writer::Add(const Event& event) { return job_->Add(ToLine(event), event, false); }
Result<Written> Writer::End() { return job_->End(); }

}  // namespace fleetpub::recording
