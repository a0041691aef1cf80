#include "schema/bundle.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "base/json.h"
#include "base/text.h"
#include "schema/uri.h"

namespace fleetpub::schema {
namespace {

using base::ToView;
using Value = base::JsonValue;

// Keywords whose values are data, whatever they look like.
constexpr std::array<std::string_view, 4> kData = {"const", "default", "enum", "examples"};

class Bundler {
 public:
  Bundler(base::JsonDocument& root, std::string_view uri, const FindDocument& find)
      : root_(root),
        allocator_(root.GetAllocator()),
        find_(find),
        root_uri_(FindBase(root, std::string(uri))) {
    if (const Value* known = base::FindMember(root, "definitions"); known && known->IsObject()) {
      for (const auto& member : known->GetObject()) names_.emplace(ToView(member.name));
    }
  }

  Result<bool> Run() {
    Walk(root_, root_uri_);
    if (!error_.empty()) return Fail(ErrorKind::kInvalid, std::move(error_));
    if (imported_.empty()) return false;
    if (base::FindMember(root_, "definitions") == nullptr) {
      root_.AddMember("definitions", Value(rapidjson::kObjectType), allocator_);
    }
    for (auto& [name, schema] : imported_) {
      root_["definitions"].AddMember(Value(name, allocator_), std::move(schema), allocator_);
    }
    return true;
  }

 private:
  // What relative references inside of the schema are seen from.
  static std::string FindBase(const Value& schema, std::string base) {
    const std::string_view id = base::StringMember(schema, "$id");
    if (id.empty() || base::FindMember(schema, "$ref") != nullptr) return base;
    return SplitFragment(ResolveUri(base, id)).first;
  }

  void Walk(Value& value, const std::string& base) {
    if (value.IsArray()) {
      for (Value& each : value.GetArray()) Walk(each, base);
    }
    if (!value.IsObject()) return;
    const std::string here = FindBase(value, base);
    const auto end = value.MemberEnd();
    for (auto member = value.MemberBegin(); member < end; ++member) {
      const std::string_view name = ToView(member->name);
      if (name == "$ref" && member->value.IsString()) {
        Redirect(member->value, here);
      } else if (std::find(kData.begin(), kData.end(), name) == kData.end()) {
        Walk(member->value, here);
      }
    }
  }

  void Redirect(Value& reference, const std::string& base) {
    const auto [uri, fragment] = SplitFragment(ResolveUri(base, ToView(reference)));
    std::string target = "#" + fragment;
    if (uri != root_uri_) {
      const std::string name = Import(uri, fragment);
      if (name.empty()) return;
      target = "#/definitions/" + base::PointerToken(name);
    }
    if (ToView(reference).starts_with('#') && base == root_uri_) return;
    reference.SetString(target, allocator_);
  }

  // The name under which the root has the schema now; empty when there is no such document.
  std::string Import(const std::string& uri, const std::string& fragment) {
    const auto known = known_.find({uri, fragment});
    if (known != known_.end()) return known->second;
    const Value* document = find_(uri);
    if (document == nullptr) return {};
    const Value* schema = base::JsonPointer(fragment.data(), fragment.size()).Get(*document);
    if (schema == nullptr) {
      error_ = fmt::format("{} has no {}", base::Printable(uri), base::Printable(fragment));
      return {};
    }
    std::string name = NameFor(uri, fragment);
    known_.emplace(std::pair(uri, fragment), name);
    Value copy(*schema, allocator_);
    Walk(copy, FindBase(*document, uri));
    if (copy.IsObject() && fragment.empty()) {
      copy.EraseMember("$schema");
      copy.EraseMember("$id");
    }
    imported_.emplace_back(name, std::move(copy));
    return name;
  }

  // What it is called there, or the file: `action`, `common`; with a number when that is taken.
  std::string NameFor(const std::string& uri, const std::string& fragment) {
    const std::string& path = fragment.empty() ? uri : fragment;
    std::string stem = path.substr(path.rfind('/') + 1);
    if (fragment.empty()) stem.resize(std::min(stem.size(), stem.find('.')));
    if (stem.empty()) stem = "schema";
    std::string name = stem;
    for (int i = 2; !names_.insert(name).second; ++i) name = fmt::format("{}{}", stem, i);
    return name;
  }

  base::JsonDocument& root_;
  base::JsonDocument::AllocatorType& allocator_;
  const FindDocument& find_;
  std::string root_uri_;
  std::set<std::string> names_;  // taken in the root's definitions
  std::map<std::pair<std::string, std::string>, std::string> known_;
  std::vector<std::pair<std::string, Value>> imported_;
  std::string error_;
};

}  // namespace

Result<bool> Bundle(base::JsonDocument& document, std::string_view uri, const FindDocument& find) {
  if (!document.IsObject()) return false;
  return Bundler(document, uri, find).Run();
}

}  // namespace fleetpub::schema
