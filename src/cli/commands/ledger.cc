// `fleetpub ledger status`, `fleetpub ledger migrate`.
#include <fmt/format.h>

#include "base/json.h"
#include "base/text.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"

namespace fleetpub::cli {
namespace {

using base::JsonString;
using ledger::LedgerInfo;

Result<LedgerInfo> Inspect(const Context& context, ledger::OpenMode mode) {
  const auto ledger = OpenLedger(context, mode);
  if (!ledger) return Fail(ledger.error());
  return (*ledger)->Describe();
}

std::string SizeText(std::int64_t bytes) {
  constexpr std::int64_t kMega = 1'000'000;
  if (bytes < kMega) return fmt::format("{} kB", (bytes + 999) / 1'000);
  return fmt::format("{:.1f} MB", static_cast<double>(bytes) / kMega);
}

Result<ExitCode> RunStatus(const Context& context) {
  const auto info = Inspect(context, ledger::OpenMode::kReadOnly);
  if (!info) return Fail(info.error());
  Output& output = context.output;
  if (output.json()) {
    output.Line(
        fmt::format(R"({{"kind":{},"place":{},"version":{},"rows":{},"topics":{},"bytes":{}}})",
                    JsonString(info->kind), JsonString(info->place), info->version, info->rows,
                    info->topics, info->bytes));
    return ExitCode::kDone;
  }
  const auto line = [&](std::string_view name, const std::string& value) {
    output.Line(fmt::format("{:<8} {}", name, value));
  };
  line("kind", info->kind);
  line("place", base::Printable(info->place));
  if (info->version == 0) {
    line("version", "none yet: the first command, or fleetpub ledger migrate, creates it");
    return ExitCode::kDone;
  }
  line("version", fmt::format("{}", info->version));
  line("rows", fmt::format("{}", info->rows));
  line("topics", fmt::format("{}", info->topics));
  line("size", SizeText(info->bytes));
  return ExitCode::kDone;
}

Result<ExitCode> RunMigrate(const Context& context) {
  const auto before = Inspect(context, ledger::OpenMode::kReadOnly);
  if (!before) return Fail(before.error());
  const auto after = Inspect(context, ledger::OpenMode::kCreate);
  if (!after) return Fail(after.error());
  if (context.output.json()) {
    context.output.Line(fmt::format(R"({{"kind":{},"place":{},"from":{},"version":{}}})",
                                    JsonString(after->kind), JsonString(after->place),
                                    before->version, after->version));
  } else if (before->version == after->version) {
    context.output.PeopleLine(
        fmt::format("{} has version {} already", base::Printable(after->place), after->version));
  } else {
    context.output.PeopleLine(
        fmt::format("{} now has version {}", base::Printable(after->place), after->version));
  }
  return ExitCode::kDone;
}

}  // namespace

Run DeclareLedgerStatus(OptionSet& /*set*/) { return RunStatus; }

Run DeclareLedgerMigrate(OptionSet& /*set*/) { return RunMigrate; }

}  // namespace fleetpub::cli
