// `fleetpub schema list`, `fleetpub schema show NAME`.
#include "schema/schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>

#include "base/json.h"
#include "base/text.h"
#include "base/width.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"

namespace fleetpub::cli {
namespace {

Result<ExitCode> RunList(const Context& context) {
  const schema::Registry registry(context.options.schema_directory);
  for (const auto& [name, origin] : registry.List()) {
    context.output.Line(context.output.json()
                            ? fmt::format(R"({{"name":{},"origin":{}}})", base::JsonString(name),
                                          base::JsonString(origin))
                            : fmt::format("{} {}", base::Padded(36, base::Printable(name)),
                                          base::Printable(origin)));
  }
  return ExitCode::kDone;
}

// `soar` means the only schema below it, `output/result` one of our own; a part is named behind
// `#`.
Result<std::string> ReadText(const schema::Registry& registry, const std::string& document) {
  auto text = registry.Text(document);
  if (text) return text;
  if (auto own = registry.Text("fleetpub/" + document)) return own;
  std::string only;
  for (const auto& [name, origin] : registry.List()) {
    if (!name.starts_with(document + "/")) continue;
    if (!only.empty()) return text;
    only = name;
  }
  return only.empty() ? text : registry.Text(only);
}

Result<ExitCode> RunShow(const std::string& name, const Context& context) {
  if (name.empty()) {
    return Fail(ErrorKind::kUsage, "name a schema. try: fleetpub schema list");
  }
  const schema::Registry registry(context.options.schema_directory);
  const auto hash = std::min(name.find('#'), name.size());
  const auto text = ReadText(registry, name.substr(0, hash));
  if (!text) return Fail(text.error());
  const auto document = base::ParseJson(*text);
  if (!document) {
    return Fail(document.error().kind,
                fmt::format("schema {}: {}", registry.FindOrigin(name), document.error().message));
  }
  const std::string pointer = name.substr(std::min(hash + 1, name.size()));
  const base::JsonPointer way(pointer.data(), pointer.size());
  const base::JsonValue* part = way.IsValid() ? way.Get(*document) : nullptr;
  if (part == nullptr) {
    return Fail(ErrorKind::kUsage,
                fmt::format("{} has no part {}", base::Printable(name.substr(0, hash)),
                            base::Printable(pointer)));
  }
  context.output.JsonLine(base::ToPrettyJson(*part));
  return ExitCode::kDone;
}

}  // namespace

Run DeclareSchemaList(OptionSet&) { return RunList; }

Run DeclareSchemaShow(OptionSet& set) {
  const auto name = std::make_shared<std::string>();
  set.AddOption("name", *name, "As schema list prints it; a part of it behind #").Type("NAME");
  return [name](const Context& context) { return RunShow(*name, context); };
}

}  // namespace fleetpub::cli
