#include "cli/layout_file.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/text.h"
#include "cli/parser/option_set.h"

namespace fleetpub::cli {

void DeclareLayoutFile(OptionSet& set, std::string& file) {
  set.AddOption("file", file, "A layout (LIF); - is standard input [layout of the configuration]")
      .Type("FILE")
      .Key("layout");
}

Result<layout::Site> LoadLayout(const std::string& file, Output& output) {
  if (file.empty()) {
    return Fail(ErrorKind::kUsage,
                "no layout is named: name its FILE, or write layout = \"hall.lif.json\" into the "
                "configuration");
  }
  auto read = layout::ReadLayoutFile(file);
  if (!read) return Fail(std::move(read.error()));
  const auto errors = std::count_if(
      read->findings.begin(), read->findings.end(),
      [](const auto& finding) { return finding.level == layout::LayoutFinding::Level::kError; });
  const auto text =
      fmt::format("{}: {} errors, {} warnings: fleetpub layout check {}", ShownFile(file), errors,
                  read->findings.size() - static_cast<std::size_t>(errors), base::Printable(file));
  if (errors > 0) {
    output.Warn(text);
  } else if (!read->findings.empty()) {
    output.Debug(text);
  }
  return std::move(read->site);
}

std::string ShownFile(const std::string& file) {
  return file == "-" ? "standard input" : base::Printable(file);
}

}  // namespace fleetpub::cli
