// `fleetpub tail [TARGET…]`: what is said, a line per message.
#include <fmt/format.h>

#include <map>
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
#include "cli/output/message_text.h"
#include "cli/output/screen.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "vda5050/reports/robot_messages.h"

namespace fleetpub::cli {
namespace {

struct TailOptions {
  ListenOptions listen;
  std::string from;
  std::optional<std::chrono::milliseconds> duration;
  bool changes = false;
};

class Tail final : public app::ListenObserver {
 public:
  Tail(const TailOptions& options, const app::Environment& environment, Output& output)
      : options_(options), environment_(environment), output_(output) {}

  Status Begin(const mqtt::ServerInfo& /*server*/,
               const std::vector<std::string>& /*filters*/) override {
    EndQuietlyOnSignals();
    return {};
  }

  Status Take(const mqtt::Message& message, const vda5050::TopicLevels* levels) override {
    auto said = DescribeMessage(message, levels);
    if (options_.changes) {
      auto& last = last_[message.topic];
      std::swap(last, said);
      said = FindNews(said, last);
      if (said.empty()) return {};
    }
    output_.Line(output_.json() ? ToJson(message, levels, said) : ToText(message, levels, said));
    if (!environment_.recording) Output::FlushNow();  // a signal may end us before GoesOn()
    return {};
  }

  void Lost(const Error& error) override { output_.Lost(error); }
  void ConnectedAgain() override { output_.ConnectedAgain(); }
  Result<bool> GoesOn() override {
    if (auto ok = output_.Flush(); !ok) return Fail(std::move(ok.error()));
    return true;
  }

 private:
  [[nodiscard]] std::string ToText(const mqtt::Message& message, const vda5050::TopicLevels* levels,
                                   const std::vector<Statement>& said) const {
    const std::string who =
        levels == nullptr
            ? base::Printable(message.topic)
            : fmt::format("{} {}", base::Printable(levels->robot.ToString()), levels->topic_name);
    return fmt::format("{}  {}  {}{}", base::FormatLocal(environment_.Now()), who,
                       JoinStatements(said), message.retained ? "  (retained)" : "");
  }

  [[nodiscard]] std::string ToJson(const mqtt::Message& message, const vda5050::TopicLevels* levels,
                                   const std::vector<Statement>& said) const {
    std::vector<std::string> texts;
    texts.reserve(said.size());
    for (const Statement& one : said) texts.push_back(one.text);
    const std::string json = vda5050::ToOneLine(message.payload);
    return fmt::format(
        R"({{"time":"{}","target":{},"name":{},"topic":{},"retained":{},"qos":{},"says":{},"message":{}}})",
        base::FormatTimestamp(environment_.Now()),
        levels == nullptr ? "null" : base::JsonString(levels->robot.ToString()),
        levels == nullptr ? "null" : base::JsonString(levels->topic_name),
        base::JsonString(message.topic), message.retained, static_cast<int>(message.qos),
        base::JsonStrings(texts), json.empty() ? "null" : json);
  }

  const TailOptions& options_;
  const app::Environment& environment_;
  Output& output_;
  std::map<std::string, std::vector<Statement>> last_;  // by topic
};

Result<ExitCode> RunTail(const TailOptions& o, const Context& context) {
  auto request = ParseListenOptions(o.listen);
  if (!request) return Fail(std::move(request.error()));
  if (o.duration && !o.from.empty()) return Fail(NoTimeFrom("--for"));
  request->end = FindEnd(o.duration);
  const auto environment = MakeEnvironment(context, o.from, delivery::Play::kAll);
  Tail tail(o, environment, context.output);
  const auto listened = app::Listen(*std::move(request), environment, tail, context.output);
  if (!listened) return Fail(listened.error());
  TellRecording(environment, context.output);
  return ExitCode::kDone;
}

}  // namespace

Run DeclareTail(OptionSet& set) {
  const auto options = std::make_shared<TailOptions>();
  DeclareListenOptions(set, options->listen);
  DeclareFrom(set, options->from);
  set.AddFlag("--changes", options->changes,
              "Only what is new since the last message of the same topic")
      .Group("Targets");
  set.AddOption("--for", Duration(options->duration), "End after this time [on Ctrl-C]")
      .Group("Waiting");
  return [options](const Context& context) { return RunTail(*options, context); };
}

}  // namespace fleetpub::cli
