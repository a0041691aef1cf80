#include "schema/schema_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "base/file.h"
#include "base/json.h"
#include "base/text.h"
#include "schema/bundle.h"
#include "schema/schema.h"
#include "schema/uri.h"

namespace fleetpub::schema {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kProtocol = "vda5050/";

// The versions and topics that there are: those that schemas are built in for.
struct Known {
  std::set<std::string, std::less<>> versions;
  std::set<std::string, std::less<>> topics;
};

Known KnownNames() {
  Known known;
  for (const Embedded& embedded : EmbeddedSchemas()) {
    if (!embedded.name.starts_with(kProtocol)) continue;
    const std::string_view rest = embedded.name.substr(kProtocol.size());
    known.versions.emplace(rest.substr(0, rest.find('/')));
    known.topics.emplace(rest.substr(rest.find('/') + 1));
  }
  return known;
}

// Without its ending; "" for what is no schema file.
std::string ParseStem(const std::string& path) {
  constexpr std::array<std::string_view, 3> kEndings = {".schema.json", ".openapi.json", ".schema"};
  const auto* ending = std::find_if(kEndings.begin(), kEndings.end(),
                                    [&path](std::string_view e) { return path.ends_with(e); });
  if (ending == kEndings.end()) return {};
  return path.substr(0, path.size() - ending->size());
}

// `3.0.0` for `3.0.0`, `v3.0` and `3.0.0-site`; the number itself for a version that we do not
// know; nothing for what is no version.
std::optional<std::string> ParseVersion(std::string_view folder, const Known& known) {
  if (folder.starts_with('v') || folder.starts_with('V')) folder.remove_prefix(1);
  const std::string_view number = folder.substr(0, folder.find_first_not_of("0123456789."));
  const std::string_view rest = folder.substr(number.size());
  if (number.find('.') == std::string_view::npos || !(rest.empty() || rest.starts_with('-'))) {
    return std::nullopt;
  }
  for (const std::string& version : known.versions) {
    if (version == number || version.starts_with(std::string(number) + ".")) return version;
  }
  return std::string(number);
}

// `instantActions` for `instant-actions`; what is not a topic stays as it is.
std::string ParseTopic(std::string_view stem, const Known& known) {
  std::string topic;
  for (std::size_t i = 0; i < stem.size(); ++i) {
    const bool joint = stem[i] == '-' && i + 1 < stem.size();
    if (joint) ++i;
    topic += joint && stem[i] >= 'a' && stem[i] <= 'z' ? static_cast<char>(stem[i] - 'a' + 'A')
                                                       : stem[i];
  }
  return known.topics.contains(topic) ? topic : std::string(stem);
}

// All names of the file with this stem; the second is true for those that give way to a file that
// is more specific.
std::vector<std::pair<std::string, bool>> MakeNames(std::string stem, const Known& known) {
  // The official repository's own folder says nothing.
  constexpr std::string_view kPublished = "json_schemas/";
  const std::size_t at = stem.find(kPublished);
  if (at != std::string::npos && (at == 0 || stem[at - 1] == '/'))
    stem.erase(at, kPublished.size());
  std::string_view rest = stem;
  if (rest.starts_with(kProtocol)) rest.remove_prefix(kProtocol.size());
  const std::size_t slash = rest.find('/');
  if (slash != std::string_view::npos) {
    const auto version = ParseVersion(rest.substr(0, slash), known);
    if (!version) return {{stem, false}};
    return {
        {fmt::format("vda5050/{}/{}", *version, ParseTopic(rest.substr(slash + 1), known)), false}};
  }
  const std::string topic = ParseTopic(rest, known);
  std::vector<std::pair<std::string, bool>> names = {{stem, false}};
  for (const Embedded& embedded : EmbeddedSchemas()) {
    const std::string_view name = embedded.name;
    if (name.starts_with(kProtocol) && name.substr(name.rfind('/') + 1) == topic) {
      names.emplace_back(name, true);
    }
  }
  return names;
}

Result<std::map<fs::path, std::string>> StemsBelow(const fs::path& folder) {
  constexpr int kDeepest = 4;
  std::map<fs::path, std::string> stems;
  std::error_code error;
  fs::recursive_directory_iterator entry(folder, fs::directory_options::skip_permission_denied,
                                         error);
  for (; !error && entry != fs::recursive_directory_iterator(); entry.increment(error)) {
    if (entry.depth() >= kDeepest) entry.disable_recursion_pending();
    std::error_code ignored;
    if (!entry->is_regular_file(ignored)) continue;
    std::string stem = ParseStem(entry->path().lexically_relative(folder).generic_string());
    if (!stem.empty()) stems.emplace(entry->path(), std::move(stem));
  }
  if (error) {
    return Fail(ErrorKind::kUsage, fmt::format("cannot read the schema folder {}: {}",
                                               folder.string(), error.message()));
  }
  return stems;
}

std::string Canonical(const fs::path& path) {
  std::error_code ignored;
  return fs::absolute(path, ignored).lexically_normal().generic_string();
}

// The documents that one may refer to. Read when first asked for.
class Documents {
 public:
  explicit Documents(const std::vector<fs::path>& files) {
    for (const fs::path& file : files) files_.emplace(Canonical(file), file);
  }

  const base::JsonValue* Find(std::string_view uri) {
    if (const auto file = files_.find(uri); file != files_.end()) {
      const auto& document = Read(file->first);
      if (!document && error_.empty()) {
        error_ = fmt::format("{}: {}", file->second.string(), document.error().message);
      }
      return document ? &*document : nullptr;
    }
    for (const auto& [path, file] : files_) {
      const auto& document = Read(path);
      if (!document) continue;
      const std::string_view id = base::StringMember(*document, "$id");
      if (!id.empty() && SplitFragment(id).first == uri) return &*document;
    }
    return nullptr;
  }

  /// Why a document that is there could not be had, or "".
  [[nodiscard]] const std::string& error() const { return error_; }

 private:
  const Result<base::JsonDocument>& Read(const std::string& path) {
    const auto known = read_.find(path);
    if (known != read_.end()) return known->second;
    const auto text = base::ReadFile(path);
    return read_.emplace(path, text ? base::ParseJson(*text) : Fail(text.error())).first->second;
  }

  std::map<std::string, fs::path, std::less<>> files_;
  std::map<std::string, Result<base::JsonDocument>> read_;
  std::string error_;
};

}  // namespace

Result<SchemaFiles> ScanSchemaFolder(const fs::path& folder) {
  const auto stems = StemsBelow(folder);
  if (!stems) return Fail(stems.error());
  if (stems->empty()) {
    return Fail(ErrorKind::kUsage,
                fmt::format("the schema folder {} holds no file that ends in .schema.json or "
                            ".schema",
                            folder.string()));
  }
  const Known known = KnownNames();
  SchemaFiles files;
  SchemaFiles fallbacks;
  for (const auto& [path, stem] : *stems) {
    for (const auto& [name, gives_way] : MakeNames(stem, known)) {
      const auto [taken, is_new] = (gives_way ? fallbacks : files).emplace(name, path);
      if (is_new) continue;
      return Fail(ErrorKind::kUsage,
                  fmt::format("the schema folder holds {} twice: {} and {}; keep one",
                              base::Printable(name), taken->second.string(), path.string()));
    }
  }
  files.merge(fallbacks);
  return files;
}

std::vector<fs::path> FilesBeside(const fs::path& file) {
  std::vector<fs::path> files;
  std::error_code error;
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  for (fs::directory_iterator entry(folder, error); !error && entry != fs::directory_iterator();
       entry.increment(error)) {
    if (!ParseStem(entry->path().filename().string()).empty()) files.push_back(entry->path());
  }
  return files;
}

Result<std::string> ReadSchemaFile(const fs::path& file, const std::vector<fs::path>& others) {
  auto text = base::ReadFile(file);
  if (!text || text->find("\"$ref\"") == std::string::npos) return text;
  auto document = base::ParseJson(*text);
  if (!document) return text;  // whoever compiles it says so
  Documents documents(others);
  const auto changed = Bundle(*document, Canonical(file),
                              [&documents](std::string_view uri) { return documents.Find(uri); });
  const std::string why = !documents.error().empty() ? documents.error()
                          : !changed                 ? changed.error().message
                                                     : "";
  if (!why.empty()) {
    return Fail(ErrorKind::kInvalid,
                fmt::format("schema {} refers to something missing: {}", file.string(), why));
  }
  return *changed ? base::ToJson(*document) : text;
}

}  // namespace fleetpub::schema
