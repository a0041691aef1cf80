// `fleetpub history`, `history show ID`, `history prune --older-than 90d`.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <limits>
#include <memory>

#include "base/json.h"
#include "base/text.h"
#include "base/time.h"
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

struct Options {
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

void ShowTable(const std::vector<Record>& records, Output& output) {
  constexpr std::array kColumns = {Column{.name = "ID", .is_number = true},
                                   Column{.name = "TIME", .rank = 1},
                                   Column{.name = "USER", .rank = 3, .least = 8},
                                   Column{.name = "TARGET", .least = 16},
                                   Column{.name = "ACTION", .least = 12},
                                   Column{.name = "HEADERID", .rank = 2, .is_number = true},
                                   Column{.name = "STATUS"}};
  std::vector<Row> rows;
  rows.reserve(records.size());
  for (const Record& record : records) {
    rows.push_back({{fmt::format("{:>6}", record.id)},
                    {base::FormatLocal(record.recorded_at)},
                    {base::Printable(record.user)},
                    {base::Printable(ShownTarget(record))},
                    {FormatTypes(record)},
                    {HeaderIdText(record)},
                    {record.status}});
  }
  PrintTable(kColumns, rows, output);
}

// What a person may write; the ledger knows the specification's names only.
Status Normalize(ledger::HistoryFilter& filter, const config::Config& config) {
  if (const auto alias = config.aliases.find(filter.target); alias != config.aliases.end()) {
    filter.target = alias->second.ToString();
  }
  const bool is_pattern =
      filter.target.find_first_of("*?") != std::string::npos || filter.target.starts_with('@');
  if (is_pattern) {
    return Fail(ErrorKind::kUsage, fmt::format("--target takes one robot or its alias, not '{}'",
                                               base::Printable(filter.target)));
  }
  if (const auto robot = vda5050::ParseRobotAddress(filter.target)) {
    filter.target = robot->ToString();
  }
  // A name that some version has is meant as it stands there.
  const auto has = [&](Version version) { return FindAction(version, filter.action) != nullptr; };
  if (std::none_of(vda5050::kVersions.begin(), vda5050::kVersions.end(), has)) {
    filter.action = vda5050::ActionCalled(filter.action).value_or(filter.action);
  }
  return {};
}

// To see whether there is another.
ledger::HistoryFilter WithOneMore(ledger::HistoryFilter filter) {
  if (filter.limit > 0 && filter.limit < std::numeric_limits<int>::max()) ++filter.limit;
  return filter;
}

Result<ExitCode> RunHistory(Options options, const Context& context) {
  if (auto ok = Normalize(options.filter, context.config); !ok) return Fail(std::move(ok.error()));
  constexpr int kOnATerminal = 50;
  const bool is_terminal = isatty(STDOUT_FILENO) == 1 && !context.output.json();
  options.filter.limit = options.limit.value_or(is_terminal ? kOnATerminal : 0);
  const auto ledger = OpenLedger(context, ledger::OpenMode::kReadOnly);
  if (!ledger) return Fail(ledger.error());
  auto records = (*ledger)->History(WithOneMore(options.filter));
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

void ShowRecord(const Record& record, Output& output) {
  const auto line = [&](std::string_view name, std::string_view value) {
    if (!value.empty()) output.Line(fmt::format("{:<10} {}", name, base::Printable(value)));
  };
  line("id", fmt::format("{}", record.id));
  line("time", base::FormatTimestamp(record.recorded_at));
  line("user", fmt::format("{} on {}", record.user, record.host));
  line("profile", record.profile);
  line("target", ShownTarget(record));
  line("protocol", fmt::format("{} {}", record.protocol, record.version));
  line("broker", record.broker);
  line("topic", record.topic);
  for (const auto& [type, id] : record.actions) line("action", fmt::format("{} {}", type, id));
  line("headerId", HeaderIdText(record));
  line("status", record.status == "RECORDED"
                     ? "RECORDED (the process ended before an outcome was known: it may have left)"
                     : record.status);
  if (record.outcome_at) line("outcome at", base::FormatTimestamp(*record.outcome_at));
  line("message", record.detail);
  const auto payload = base::ParseJson(record.payload);
  payload ? output.JsonLine(base::ToPrettyJson(*payload))
          : output.Line(base::Printable(record.payload));
}

Result<ExitCode> RunShow(std::optional<std::int64_t> id, const Context& context) {
  if (!id) {
    return Fail(ErrorKind::kUsage,
                "history show takes the number that fleetpub history prints under ID");
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
    return Fail(ErrorKind::kUsage, "say what may go: history prune --older-than 90d");
  }
  const auto ledger = OpenLedger(context, ledger::OpenMode::kCreate);
  if (!ledger) return Fail(ledger.error());
  const auto count = (*ledger)->Prune(*before);
  if (!count) return Fail(count.error());
  if (context.output.json()) {
    context.output.Line(fmt::format(R"({{"pruned":{}}})", *count));
  } else {
    context.output.PeopleLine(
        fmt::format("{} row{} removed; header ids are kept", *count, *count == 1 ? "" : "s"));
  }
  return ExitCode::kDone;
}

}  // namespace

Run DeclareHistory(OptionSet& set) {
  constexpr const char* kFilter = "Filter";
  const auto options = std::make_shared<Options>();
  ledger::HistoryFilter& filter = options->filter;
  const auto add = [&](const char* names, ValueKind kind, const char* type, const char* help) {
    set.AddOption(names, std::move(kind), help).Type(type).Group(kFilter);
  };
  add("--target", Text(filter.target), "TARGET", "Only what was sent to this robot");
  add("--action", Text(filter.action), "TYPE", "Only this actionType, or its short name");
  add("--status", OneOf(filter.status, message::kRecordedStatuses), "STATUS",
      "Only this outcome: {}");
  add("--user", Text(filter.user), "USER", "Only what this user sent");
  add("--since", PointInTime(filter.since, Direction::kBack), "TIME",
      "Not older: 24h, or 2026-01-02T03:04:05Z");
  add("--until", PointInTime(filter.until, Direction::kBack), "TIME", "Not newer");
  add("--limit", WholeNumber(options->limit), "N",
      "The newest so many; 0: all [50 on a terminal, else 0]");
  return [options](const Context& context) { return RunHistory(*options, context); };
}

Run DeclareHistoryShow(OptionSet& set) {
  const auto id = std::make_shared<std::optional<std::int64_t>>();
  set.AddOption("id", WholeNumber(*id), "As history prints it").Type("ID");
  return [id](const Context& context) { return RunShow(*id, context); };
}

Run DeclareHistoryPrune(OptionSet& set) {
  const auto older_than = std::make_shared<std::optional<base::WallTime>>();
  set.AddOption("--older-than", PointInTime(*older_than, Direction::kBack),
                "Age such as 90d, or a time")
      .Group("Pruning");
  return [older_than](const Context& context) { return RunPrune(*older_than, context); };
}

}  // namespace fleetpub::cli
