#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <system_error>

#include "base/file.h"
#include "base/text.h"
#include "schema/schema.h"
#include "schema/uri.h"

namespace fleetpub::schema {
namespace {

namespace fs = std::filesystem;

// The name of a file, or "" for one that is no schema: the path without the ending, `vda5050/` put
// before a version.
std::string NameOf(const fs::path& relative) {
  constexpr std::array<std::string_view, 3> kEndings = {".schema.json", ".openapi.json", ".schema"};
  std::string name = relative.generic_string();
  const auto* ending = std::find_if(kEndings.begin(), kEndings.end(),
                                    [&name](std::string_view e) { return name.ends_with(e); });
  if (ending == kEndings.end()) return {};
  name.resize(name.size() - ending->size());
  const std::string_view first = std::string_view(name).substr(0, name.find('/'));
  const bool version = !first.empty() && first.size() < name.size() &&
                       first.find_first_not_of("0123456789.") == std::string_view::npos;
  return version ? "vda5050/" + name : name;
}

const Embedded* FindEmbedded(std::string_view name) {
  const auto all = EmbeddedSchemas();
  const auto it = std::find_if(all.begin(), all.end(),
                               [name](const Embedded& schema) { return schema.name == name; });
  return it == all.end() ? nullptr : &*it;
}

}  // namespace

Registry::Registry(fs::path directory) : directory_(std::move(directory)) {
  if (directory_.empty()) return;
  constexpr int kDeepest = 4;
  std::error_code error;
  fs::recursive_directory_iterator entry(directory_, fs::directory_options::skip_permission_denied,
                                         error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    if (entry.depth() >= kDeepest) entry.disable_recursion_pending();
    const std::string name = NameOf(entry->path().lexically_relative(directory_));
    std::error_code ignored;
    if (name.empty() || !entry->is_regular_file(ignored)) continue;
    const auto [known, is_new] = files_.emplace(name, entry->path());
    if (!is_new) known->second = std::min(known->second, entry->path());
  }
  if (error) {
    scanned_ = Fail(ErrorKind::kUsage, fmt::format("cannot read the schema folder {}: {}",
                                                   directory_.string(), error.message()));
  }
}

Result<std::string> Registry::Text(std::string_view name) const {
  if (!scanned_) return Fail(scanned_.error());
  if (const auto file = files_.find(name); file != files_.end()) {
    return base::ReadFile(file->second);
  }
  if (const Embedded* embedded = FindEmbedded(name)) return std::string(embedded->text);
  std::vector<std::string_view> names;
  for (const auto& [known, path] : files_) names.push_back(known);
  for (const Embedded& embedded : EmbeddedSchemas()) names.push_back(embedded.name);
  const auto near = base::Nearest(name, names);
  return Fail(ErrorKind::kUsage,
              fmt::format("no schema is called {}; {}", base::Printable(name),
                          near ? fmt::format("did you mean {}?", *near)
                               : "`fleetpub schema list` shows those there are"));
}

Result<const Schema*> Registry::Find(std::string_view name) {
  if (const auto known = compiled_.find(name); known != compiled_.end()) return &known->second;
  const auto [document, pointer] = SplitFragment(name);
  const auto text = Text(document);
  if (!text) return Fail(text.error());
  const auto file = files_.find(document);
  const std::string shown = file == files_.end() ? document : file->second.string();
  auto schema = Schema::Compile(*text, shown, pointer);
  if (!schema) return Fail(std::move(schema.error()));
  return &compiled_.emplace(std::string(name), std::move(*schema)).first->second;
}

std::vector<std::pair<std::string, std::string>> Registry::List() const {
  std::map<std::string, std::string> all;
  for (const Embedded& embedded : EmbeddedSchemas()) {
    all.emplace(embedded.name, "built-in");
  }
  for (const auto& [name, path] : files_) all.insert_or_assign(name, path.string());
  return {all.begin(), all.end()};
}

}  // namespace fleetpub::schema
