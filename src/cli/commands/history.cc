// `fleetpub history`, `history show ID`, `history prune --older-than 90d`.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <memory>

#include "app/targets.h"
#include "base/json.h"
#include "base/local_time.h"
#include "base/text.h"
#include "base/time.h"
#include "cli/output/fleet_table.h"
#include "cli/output/screen.h"
#include "cli/output/table.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"
#include "ledger/postgres/postgres_url.h"
#include "message/command_status.h"
#include "vda5050/catalogue/catalogue.h"
#include "vda5050/model/robot_address.h"

namespace fleetpub::cli {
namespace {

using base::JsonString;
using ledger::Record;
using vda5050::Version;

struct HistoryOptions {
  std::vector<std::string> words;    ///< robots, aliases, groups, patterns, SoAR destinations
  std::vector<std::string> targets;  ///< the same, of --target
  ledger::HistoryFilter filter;
  std::optional<int> limit;  ///< nothing: as many as suit whoever reads
};

// Older rows hold robots' names as they are, which may be patterns as targets.
std::string ShownTarget(const Record& record) {
  const auto robot = vda5050::ParseRobotAddress(record.target);
  return robot ? robot->ToString() : record.target;
}

std::string ActionsJson(const Record& record) {
  std::string json;
  for (const auto& [type, id] : record.actions) {
    json += fmt::format(R"({}{{"type":{},"id":{}}})", json.empty() ? "" : ",", JsonString(type),
                        JsonString(id));
  }
  return "[" + json + "]";
}

std::string RecordJson(const Record& record) {
  std::string json = fmt::format(
      R"({{"id":{},"time":"{}","user":{},"host":{},"broker":{},"target":{},"protocol":{},)"
      R"("version":{},"topic":{},"actions":{})",
      record.id, base::FormatTimestamp(record.recorded_at), JsonString(record.user),
      JsonString(record.host), JsonString(record.broker), JsonString(ShownTarget(record)),
      JsonString(record.protocol), JsonString(record.version), JsonString(record.topic),
      ActionsJson(record));
  if (!record.profile.empty()) json += R"(,"profile":)" + JsonString(record.profile);
  if (record.header_id) json += fmt::format(R"(,"headerId":{})", *record.header_id);
  json += fmt::format(R"(,"status":{})", JsonString(record.status));
  if (record.outcome_at) {
    json += fmt::format(R"(,"outcomeTime":"{}")", base::FormatTimestamp(*record.outcome_at));
  }
  if (!record.detail.empty()) json += R"(,"message":)" + JsonString(record.detail);
  // What was sent is JSON; what a file's damage has left of it may not be.
  const bool is_json = base::ParseJson(record.payload).has_value();
  return json + R"(,"payload":)" + (is_json ? record.payload : JsonString(record.payload)) + "}";
}

std::string FormatTypes(const Record& record) {
  std::vector<std::string> types;
  for (const auto& action : record.actions) types.push_back(action.type);
  return base::Printable(base::Join(types, ","));
}

std::string HeaderIdText(const Record& record) {
  return record.header_id ? fmt::format("{}", *record.header_id) : "-";
}

constexpr std::string_view kMayHaveLeft =
    "the process ended before an outcome was known: it may have been sent";

std::string ReasonText(const Record& record) {
  if (record.detail.empty() && record.status == "RECORDED") return std::string(kMayHaveLeft);
  return base::Printable(base::WithLocalTimes(record.detail));
}

void ShowTable(const std::vector<Record>& records, Output& output) {
  constexpr std::array kColumns = {Column{.name = "ID", .is_number = true},
                                   Column{.name = "LOCAL TIME", .rank = 1},
                                   Column{.name = "USER", .rank = 4, .least = 8},
                                   Column{.name = "TARGET", .least = 16},
                                   Column{.name = "ACTION", .least = 12},
                                   Column{.name = "HEADERID", .rank = 3, .is_number = true},
                                   Column{.name = "STATUS"},
                                   Column{.name = "REASON", .rank = 2, .least = 16}};
  std::vector<Row> rows;
  rows.reserve(records.size());
  for (const Record& record : records) {
    rows.push_back({{fmt::format("{:>6}", record.id)},
                    {base::FormatLocal(record.recorded_at)},
                    {base::Printable(record.user)},
                    {base::Printable(ShownTarget(record))},
                    {FormatTypes(record)},
                    {HeaderIdText(record)},
                    {record.status},
                    {ReasonText(record)}});
  }
  PrintTable(kColumns, rows, output);
}

// An action as a person may write it; the ledger knows the specification's names only.
void Normalize(ledger::HistoryFilter& filter) {
  // A name that some version has is meant as it stands there.
  const auto has = [&](Version version) { return FindAction(version, filter.action) != nullptr; };
  if (std::none_of(vda5050::kVersions.begin(), vda5050::kVersions.end(), has)) {
    filter.action = vda5050::ActionCalled(filter.action).value_or(filter.action);
  }
}

// Whose rows are wanted; nothing: everybody's.
struct Wanted {
  std::vector<std::string> destinations;  ///< of SoAR, exactly
  app::TargetSpec robots;

  [[nodiscard]] bool IsOne() const {
    return robots.patterns.empty() && robots.robots.size() + destinations.size() == 1;
  }
  [[nodiscard]] bool Has(const Record& record) const {
    const auto robot = vda5050::ParseRobotAddress(record.target);
    if (!robot) {
      return std::find(destinations.begin(), destinations.end(), record.target) !=
             destinations.end();
    }
    return std::find(robots.robots.begin(), robots.robots.end(), *robot) != robots.robots.end() ||
           std::any_of(robots.patterns.begin(), robots.patterns.end(),
                       [&](const auto& pattern) { return pattern.Matches(*robot); });
  }
};

Result<Wanted> FindWanted(std::vector<std::string> words, const Context& context) {
  const auto is_destination = [&](const std::string& word) {
    return word.find_first_of("/@*?") == std::string::npos &&
           !context.config.aliases.contains(word);
  };
  for (const std::string& word : words) {
    if (word.find_first_not_of("0123456789") != std::string::npos) continue;
    return Fail(
        ErrorKind::kUsage,
        fmt::format("history takes robots, not '{0}'. try: fleetpub history show {0}", word));
  }
  const auto others = std::stable_partition(words.begin(), words.end(), is_destination);
  Wanted wanted{.destinations = {words.begin(), others}, .robots = {}};
  auto robots = app::ParseTargetSpec({others, words.end()}, context.config, context.output);
  if (!robots) return Fail(std::move(robots.error()));
  wanted.robots = *std::move(robots);
  return wanted;
}

// The newest rows of those who are wanted, and one more than the limit if there is one: the ledger
// finds one target's rows, of several they are picked from its pages.
Result<std::vector<Record>> ReadRows(ledger::Ledger& ledger, ledger::HistoryFilter filter,
                                     const Wanted& wanted, bool all) {
  const std::size_t most = filter.limit > 0 ? static_cast<std::size_t>(filter.limit) + 1
                                            : std::numeric_limits<std::size_t>::max();
  if (wanted.IsOne()) {
    filter.target = wanted.robots.robots.empty() ? wanted.destinations.front()
                                                 : wanted.robots.robots.front().ToString();
  }
  constexpr int kPage = 1'000;
  const bool is_picked = !all && !wanted.IsOne();
  if (is_picked) {
    filter.limit = kPage;
  } else if (filter.limit > 0 && filter.limit < std::numeric_limits<int>::max()) {
    ++filter.limit;
  }
  std::vector<Record> rows;
  for (;;) {
    auto page = ledger.History(filter);
    if (!page || !is_picked) return page;
    for (auto row = page->rbegin(); row != page->rend() && rows.size() < most; ++row) {
      if (wanted.Has(*row)) rows.push_back(std::move(*row));
    }
    if (page->size() < kPage || rows.size() == most) break;
    filter.below = page->front().id;
  }
  std::reverse(rows.begin(), rows.end());
  return rows;
}

// So many that neither the header nor what is typed next scrolls away.
int RowsThatFit() {
  constexpr std::size_t kOthers = 3;
  constexpr std::size_t kLeast = 5;
  const std::size_t height = Screen::size().rows;
  return static_cast<int>(std::max(height, kLeast + kOthers) - kOthers);
}

Result<ExitCode> RunHistory(HistoryOptions options, const Context& context) {
  Normalize(options.filter);
  std::vector<std::string>& words = options.words;
  words.insert(words.end(), options.targets.begin(), options.targets.end());
  const auto wanted = FindWanted(words, context);
  if (!wanted) return Fail(wanted.error());
  const bool is_terminal = isatty(STDOUT_FILENO) == 1 && !context.output.json();
  options.filter.limit = options.limit.value_or(is_terminal ? RowsThatFit() : 0);
  const auto ledger = OpenLedger(context, ledger::OpenMode::kReadOnly);
  if (!ledger) return Fail(ledger.error());
  auto records = ReadRows(**ledger, options.filter, *wanted, words.empty());
  if (!records) return Fail(records.error());
  const bool has_more =
      options.filter.limit > 0 && records->size() > static_cast<std::size_t>(options.filter.limit);
  if (has_more) {
    records->erase(records->begin());
    context.output.Info("older ones are not shown: --limit 0 shows all");
  }
  if (const std::string& path = context.options.ledger;
      records->empty() && !path.empty() && !ledger::IsUrl(path) && !std::filesystem::exists(path)) {
    context.output.Warn(fmt::format("there is no ledger at {}", base::Printable(path)));
  }
  if (context.output.json()) {
    for (const Record& record : *records) context.output.Line(RecordJson(record));
  } else if (records->empty()) {
    context.output.PeopleLine("nothing was sent, or nothing that matches");
  } else {
    ShowTable(*records, context.output);
  }
  return ExitCode::kDone;
}

// `2026-01-02 03:04:05 local time, 3 min ago`
std::string MomentText(base::WallTime time) {
  const auto age = std::max(base::WallTime::clock::now() - time, base::WallTime::duration::zero());
  return fmt::format("{} local time, {} ago", base::FormatLocal(time), AgeText(age));
}

void ShowRecord(const Record& record, Output& output) {
  const auto line = [&](std::string_view name, std::string_view value) {
    if (!value.empty()) output.Line(fmt::format("{:<10} {}", name, base::Printable(value)));
  };
  line("id", fmt::format("{}", record.id));
  line("time", MomentText(record.recorded_at));
  line("user", fmt::format("{} on {}", record.user, record.host));
  line("profile", record.profile);
  line("target", ShownTarget(record));
  line("protocol", fmt::format("{} {}", record.protocol, record.version));
  line("broker", record.broker);
  line("topic", record.topic);
  for (const auto& [type, id] : record.actions) line("action", fmt::format("{} {}", type, id));
  line("headerId", HeaderIdText(record));
  line("status",
       record.status == "RECORDED" ? fmt::format("RECORDED ({})", kMayHaveLeft) : record.status);
  if (record.outcome_at) line("outcome at", MomentText(*record.outcome_at));
  line("message", base::WithLocalTimes(record.detail));
  const auto payload = base::ParseJson(record.payload);
  payload ? output.JsonLine(base::ToPrettyJson(*payload))
          : output.Line(base::Printable(record.payload));
}

Result<ExitCode> RunShow(std::optional<std::int64_t> id, const Context& context) {
  if (!id) {
    return Fail(ErrorKind::kUsage,
                "history show takes the number that fleetpub history prints under ID. try: "
                "fleetpub history show 42");
  }
  const auto ledger = OpenLedger(context, ledger::OpenMode::kReadOnly);
  if (!ledger) return Fail(ledger.error());
  const auto record = (*ledger)->Find(*id);
  if (!record) return Fail(record.error());
  if (!*record) return Fail(ErrorKind::kUsage, fmt::format("the history has no message {}", *id));
  if (context.output.json()) {
    context.output.Line(RecordJson(**record));
  } else {
    ShowRecord(**record, context.output);
  }
  return ExitCode::kDone;
}

Result<ExitCode> RunPrune(std::optional<base::WallTime> before, const Context& context) {
  if (!before) {
    return Fail(ErrorKind::kUsage,
                "history prune needs an age. try: fleetpub history prune --older-than 90d");
  }
  const auto ledger = OpenLedger(context, ledger::OpenMode::kCreate);
  if (!ledger) return Fail(ledger.error());
  const auto count = (*ledger)->Prune(*before);
  if (!count) return Fail(count.error());
  if (context.output.json()) {
    context.output.Line(fmt::format(R"({{"pruned":{}}})", *count));
  } else {
    context.output.PeopleLine(base::Counted(*count, "row") + " removed; header ids are kept");
  }
  return ExitCode::kDone;
}

}  // namespace

Run DeclareHistory(OptionSet& set) {
  constexpr const char* kFilter = "Filter";
  const auto options = std::make_shared<HistoryOptions>();
  ledger::HistoryFilter& filter = options->filter;
  const auto add = [&](const char* names, ValueKind kind, const char* type, const char* help) {
    set.AddOption(names, std::move(kind), help).Type(type).Group(kFilter);
  };
  set.AddOption("targets", options->words,
                "Robots: manufacturer/serialNumber, alias, @group, 'KIT/*'; a destination [all]")
      .Type("TARGET");
  set.AddOption("--target", options->targets, "The same, as an option; repeatable")
      .Type("TARGET")
      .OneValueEach()
      .Group(kFilter);
  add("--action", Text(filter.action), "TYPE", "Only this actionType, or its short name");
  add("--status", OneOf(filter.status, message::kRecordedStatuses), "STATUS",
      "Only this outcome: {}");
  add("--user", Text(filter.user), "USER", "Only what this user sent");
  add("--since", PointInTime(filter.since, base::Direction::kBack), "TIME",
      "Not older: 2h, 14:30, today, 'monday 06:00', 2026-01-02, 2026-01-02T03:04:05Z");
  add("--until", PointInTime(filter.until, base::Direction::kBack), "TIME",
      "Not newer, in the same words");
  add("--limit", WholeNumber(options->limit), "N",
      "The newest so many; 0: all [what fits on a terminal, else 0]");
  return [options](const Context& context) { return RunHistory(*options, context); };
}

Run DeclareHistoryShow(OptionSet& set) {
  const auto id = std::make_shared<std::optional<std::int64_t>>();
  set.AddOption("id", WholeNumber(*id), "As history prints it").Type("ID");
  return [id](const Context& context) { return RunShow(*id, context); };
}

Run DeclareHistoryPrune(OptionSet& set) {
  const auto older_than = std::make_shared<std::optional<base::WallTime>>();
  set.AddOption("--older-than", PointInTime(*older_than, base::Direction::kBack),
                "Age such as 90d, or a time")
      .Group("Pruning");
  return [older_than](const Context& context) { return RunPrune(*older_than, context); };
}

}  // namespace fleetpub::cli
