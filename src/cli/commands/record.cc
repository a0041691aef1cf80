// `fleetpub record [TARGET…] -f FILE`: writes down what is said.
#include <fmt/format.h>

#include <chrono>
#include <memory>
#include <optional>
#include <utility>

#include "app/listen.h"
#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/environment.h"
#include "cli/listening.h"
#include "cli/options/listen_options.h"
#include "cli/output/interrupt.h"
#include "cli/output/stop_signal.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "config/config_settings.h"
#include "delivery/recorded.h"
#include "recording/writer.h"

namespace fleetpub::cli {
namespace {

using std::chrono::microseconds;
using std::chrono::steady_clock;

struct RecordOptions {
  ListenOptions listen;
  std::string file;
  std::optional<std::chrono::milliseconds> duration;
  recording::Rotation rotation;
  mqtt::Qos qos = mqtt::kListeningQos;
};

// `100MB`, or a time: `1h`.
bool ParseRotation(std::string_view text, recording::Rotation& rotation) {
  constexpr std::array<std::pair<std::string_view, std::uint64_t>, 3> kUnits = {
      {{"kb", 1'000}, {"mb", 1'000'000}, {"gb", 1'000'000'000}}};
  const std::string lower = base::ToLower(text);
  for (const auto& [unit, bytes] : kUnits) {
    if (!lower.ends_with(unit)) continue;
    const auto count = ParseBetween<std::uint64_t>(
        std::string_view(lower).substr(0, lower.size() - unit.size()), 1, 1'000'000);
    if (count) rotation.bytes = *count * bytes;
    return count.has_value();
  }
  const auto time = base::ParseDuration(text);
  if (!time || time->count() == 0) return false;
  rotation.time = *time;
  return true;
}

ValueKind RotationKind(recording::Rotation& rotation) {
  return {.type = "SIZE",
          .store =
              [&rotation](const std::vector<std::string>& texts) {
                return ParseRotation(texts.front(), rotation);
              },
          .takes = [] { return std::string("a time such as 1h or a size such as 100MB"); }};
}

std::string FormatBytes(std::uint64_t bytes) {
  if (bytes < 1'000'000) return fmt::format("{:.1f} kB", static_cast<double>(bytes) / 1e3);
  return fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6);
}

class Recorder final : public app::ListenObserver {
 public:
  Recorder(const RecordOptions& options, Output& output) : options_(options), output_(output) {}

  Status Begin(const mqtt::ServerInfo& server, const std::vector<std::string>& filters) override {
    recording::WriterOptions writer{.path = options_.file, .rotation = options_.rotation};
    writer.head =
        delivery::MakeHead("fleetpub " FLEETPUB_VERSION, server, filters, options_.qos, start_);
    writer.head.retain_as_published = server.version == mqtt::ProtocolVersion::k5;
    auto opened = recording::Writer::Open(std::move(writer));
    if (!opened) return Fail(std::move(opened.error()));
    writer_ = *std::move(opened);
    stop_.emplace();
    output_.Info(fmt::format("recording {} into {}; Ctrl-C ends it", server.broker.ToString(),
                             base::Printable(options_.file)));
    return writer_->Add(MakeEvent("connected", server.broker.ToString()));
  }

  Status Take(const mqtt::Message& message, const vda5050::TopicLevels* /*levels*/) override {
    return writer_->Add(delivery::ToRecorded(message, Now()));
  }

  void Lost(const Error& error) override {
    output_.Lost(error);
    lost_ = Now();
    static_cast<void>(writer_->Add(MakeEvent("lost", error.message)));
  }

  void ConnectedAgain() override {
    output_.ConnectedAgain();
    auto gap = MakeEvent("gap", "what was published meanwhile is missing");
    gap.lasted = gap.t - lost_.t;
    ++gaps_;
    static_cast<void>(writer_->Add(gap));
    static_cast<void>(writer_->Add(MakeEvent("resubscribed", "")));
  }

  Result<bool> GoesOn() override { return !StopSignal::Received(); }

  /// Once. Errors: ErrorKind::kLedger.
  Result<recording::Written> End() { return writer_->End(); }
  [[nodiscard]] bool has_begun() const { return writer_ != nullptr; }
  [[nodiscard]] int gaps() const { return gaps_; }
  [[nodiscard]] microseconds Lasted() const { return Now().t; }

 private:
  [[nodiscard]] recording::Moment Now() const { return delivery::MomentSince(start_); }
  [[nodiscard]] recording::Event MakeEvent(std::string kind, std::string text) const {
    recording::Event event;
    static_cast<recording::Moment&>(event) = Now();
    event.kind = std::move(kind);
    event.text = std::move(text);
    return event;
  }

  const RecordOptions& options_;
  Output& output_;
  const InterruptGuard before_;
  std::optional<StopSignal> stop_;
  steady_clock::time_point start_ = steady_clock::now();
  std::unique_ptr<recording::Writer> writer_;
  recording::Moment lost_;
  int gaps_ = 0;
};

void ShowSummary(const RecordOptions& o, const recording::Written& written,
                 const Recorder& recorder, Output& output) {
  if (output.json()) {
    return output.Line(fmt::format(
        R"({{"file":{},"files":{},"messages":{},"overflow":{},"gaps":{},"bytes":{},"seconds":{:.3f}}})",
        base::JsonString(o.file), written.files, written.messages, written.lost, recorder.gaps(),
        written.bytes, static_cast<double>(recorder.Lasted().count()) / 1e6));
  }
  const int gaps = recorder.gaps();
  output.PeopleLine(fmt::format(
      "{} in {}, {}{}{}", base::Counted(written.messages, "message"),
      base::FormatElapsed(recorder.Lasted()), FormatBytes(written.bytes),
      written.files == 1 ? "" : fmt::format(" in {} files", written.files),
      gaps == 0 ? "" : fmt::format("; {}: the connection was lost", base::Counted(gaps, "gap"))));
}

Result<ExitCode> RunRecord(const RecordOptions& o, const Context& context) {
  if (o.file.empty()) {
    return Fail(ErrorKind::kUsage,
                "record needs a file to write. try: fleetpub record 'KIT/*' -f shift.jsonl");
  }
  auto request = ParseListenOptions(o.listen);
  if (!request) return Fail(std::move(request.error()));
  request->qos = o.qos;
  request->end = FindEnd(o.duration);
  Recorder recorder(o, context.output);
  const auto environment = MakeEnvironment(context, {}, Retained::kAsPublished);
  const auto listened = app::Listen(*std::move(request), environment, recorder, context.output);
  if (!recorder.has_begun()) return Fail(listened.error());
  const auto written = recorder.End();
  if (!written) return Fail(written.error());
  ShowSummary(o, *written, recorder, context.output);
  if (!listened) return Fail(listened.error());
  if (written->lost > 0) {
    return Fail(ErrorKind::kLedger,
                fmt::format("{} lost: messages came faster than {} could be written",
                            base::Counted(written->lost, "message"), base::Printable(o.file)));
  }
  return ExitCode::kDone;
}

}  // namespace

Run DeclareRecord(OptionSet& set) {
  constexpr const char* kRecording = "Recording";
  const auto options = std::make_shared<RecordOptions>();
  DeclareListenOptions(set, options->listen);
  set.AddOption("-f,--file", NewFile(options->file),
                "A new file; compressed when its name ends in .zst or .gz")
      .Type("FILE")
      .Group(kRecording);
  set.AddOption("--for", Duration(options->duration), "End after this time [on Ctrl-C]")
      .Group(kRecording);
  set.AddOption("--rotate", RotationKind(options->rotation),
                "Begin a new file after a time or a size: 1h, 100MB; FILE.0001 … [never]")
      .Group(kRecording);
  set.AddOption("-q,--qos", OneOf(options->qos, config::kQos),
                "{}: none is recorded above it; above 0 brokers may drop what comes fast [0]")
      .Group(kRecording);
  return [options](const Context& context) { return RunRecord(*options, context); };
}

}  // namespace fleetpub::cli
