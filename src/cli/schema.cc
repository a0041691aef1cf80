// `fleetpub schema list`, `fleetpub schema show NAME`.
#include "schema/schema.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>

#include "base/json.h"
#include "cli/option_set.h"
#include "cli/subcommand.h"

namespace fleetpub::cli {
namespace {

Result<ExitCode> RunList(const Context& context) {
  const schema::Registry registry(context.options.schema_directory);
  for (const auto& [name, origin] : registry.List()) {
    context.output.Line(context.output.json()
                            ? fmt::format(R"({{"name":{},"origin":{}}})", base::JsonString(name),
                                          base::JsonString(origin))
                            : fmt::format("{:<36} {}", name, origin));
  }
  return ExitCode::kDone;
}

Result<ExitCode> RunShow(const std::string& name, const Context& context) {
  if (name.empty()) {
    return Fail(ErrorKind::kUsage, "name a schema: fleetpub schema list shows them");
  }
  const schema::Registry registry(context.options.schema_directory);
  const auto text = registry.Text(name);
  if (!text) return Fail(text.error());
  const auto document = base::ParseJson(*text);
  if (!document) {
    return Fail(document.error().kind,
                fmt::format("schema {}: {}", registry.OriginOf(name), document.error().message));
  }
  context.output.Line(base::ToPrettyJson(*document));
  return ExitCode::kDone;
}

}  // namespace

Run DeclareSchemaList(OptionSet&) { return RunList; }

Run DeclareSchemaShow(OptionSet& set) {
  const auto name = std::make_shared<std::string>();
  set.AddOption("name", *name, "As schema list prints it")->type_name("NAME");
  return [name](const Context& context) { return RunShow(*name, context); };
}

}  // namespace fleetpub::cli
