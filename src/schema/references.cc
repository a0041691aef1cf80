#include "schema/references.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <utility>

#include "base/json.h"
#include "base/text.h"
#include "schema/uri.h"
#include "schema/vet.h"

namespace fleetpub::schema {
namespace {

using base::ViewOf;
using Value = base::JsonValue;

// A validator's stack holds this many schemas for each level of the message
// (base::JsonLimits::depth).
constexpr int kLongestChain = 32;

std::string Unescape(std::string_view token) {  // RFC 6901 §4
  std::string name;
  for (std::size_t i = 0; i < token.size(); ++i) {
    const bool escape = token[i] == '~' && i + 1 < token.size();
    if (escape && (token[i + 1] == '0' || token[i + 1] == '1')) {
      name += token[++i] == '0' ? '~' : '/';
    } else {
      name += token[i];
    }
  }
  return name;
}

const Value* Step(const Value& value, std::string_view token) {
  if (value.IsObject()) return base::FindMember(value, Unescape(token));
  if (!value.IsArray()) return nullptr;
  if (token.size() > 1 && token.front() == '0') return nullptr;
  rapidjson::SizeType index = 0;
  const char* end = token.data() + token.size();
  const auto [stop, error] = std::from_chars(token.data(), end, index);
  return error == std::errc() && stop == end && index < value.Size() ? &value[index] : nullptr;
}

// Finds the longest chain of schemas that apply to one and the same value.
class ChainWalk {
 public:
  explicit ChainWalk(const Vetted& vetted) : vetted_(vetted) {}

  enum class CommandStatus { kFine, kCycle, kTooLong };

  CommandStatus Walk(const Value& schema, int level) {
    if (level > kLongestChain) return CommandStatus::kTooLong;
    const auto [entry, is_new] = below_.emplace(&schema, kOpen);
    if (!is_new && entry->second == kOpen) return CommandStatus::kCycle;
    if (!is_new) {
      return level + entry->second > kLongestChain ? CommandStatus::kTooLong : CommandStatus::kFine;
    }
    int longest = 0;
    CommandStatus status = CommandStatus::kFine;
    ForEachApplied(schema, [&](const Value& applied) {
      if (status == CommandStatus::kFine) status = Walk(applied, level + 1);
      if (status == CommandStatus::kFine) longest = std::max(longest, below_[&applied] + 1);
    });
    below_[&schema] = longest;
    return status;
  }

 private:
  template <typename Function>
  void ForEachApplied(const Value& schema, const Function& apply) const {
    if (const Value* target = vetted_.Reference(schema)) apply(*target);
    if (vetted_.OnlyReference(schema) != nullptr) return;
    constexpr std::array<std::string_view, 3> kLists = {"allOf", "anyOf", "oneOf"};
    for (const std::string_view keyword : kLists) {
      const Value* list = base::FindMember(schema, keyword);
      if (list == nullptr) continue;
      for (const Value& item : list->GetArray()) apply(item);
    }
    constexpr std::array<std::string_view, 4> kSingle = {"not", "if", "then", "else"};
    for (const std::string_view keyword : kSingle) {
      if (const Value* single = base::FindMember(schema, keyword)) apply(*single);
    }
    const Value* dependencies = base::FindMember(schema, "dependencies");
    if (dependencies == nullptr) return;
    for (const auto& member : dependencies->GetObject()) {
      if (!member.value.IsArray()) apply(member.value);
    }
  }

  static constexpr int kOpen = -1;
  const Vetted& vetted_;
  std::unordered_map<const Value*, int> below_;  // length of the longest chain that begins here
};

}  // namespace

std::string Place::Pointer() const {
  if (up == nullptr) return std::string(prefix);
  const std::string above = up->Pointer();
  if (name.data() == nullptr) return fmt::format("{}/{}", above, index);
  return fmt::format("{}/{}", above, base::PointerToken(name));
}

const Value* Follow(const Value& document, std::string_view pointer) {
  const Value* value = &document;
  while (value != nullptr && !pointer.empty()) {
    pointer.remove_prefix(1);
    const std::string_view token = pointer.substr(0, pointer.find('/'));
    value = Step(*value, token);
    pointer.remove_prefix(token.size());
  }
  return value;
}

ReferenceTable::ReferenceTable(Vetted& vetted) : vetted_(vetted) {
  documents_.emplace("", &vetted.document);
}

bool ReferenceTable::Identify(const Value& schema, std::string_view id, Place& here) {
  const std::string full = ResolveUri(here.base, id);
  const auto [uri, fragment] = SplitFragment(full);
  if (!fragment.empty() && !anchors_.emplace(uri + "#" + fragment, &schema).second) return false;
  if (id.starts_with('#')) return true;
  const auto [document, is_new] = documents_.emplace(uri, &schema);
  here.base = document->first;
  return is_new || !fragment.empty() || document->second == &schema;
}

void ReferenceTable::Add(const Value& schema, std::string_view reference, const Place& place) {
  auto [uri, fragment] = SplitFragment(ResolveUri(place.base, reference));
  references_.push_back(
      {&schema, std::string(reference), std::move(uri), std::move(fragment), place.Pointer()});
}

const Value* ReferenceTable::Find(const Reference& reference) const {
  if (!reference.fragment.empty() && !reference.fragment.starts_with('/')) {
    const auto anchor = anchors_.find(reference.uri + "#" + reference.fragment);
    return anchor == anchors_.end() ? nullptr : anchor->second;
  }
  return Follow(*documents_.at(reference.uri), reference.fragment);
}

auto ReferenceTable::Resolve(std::size_t index) -> Checked<Found> {
  const Reference& reference = references_[index];
  const std::string place = base::Printable(reference.place);
  const std::string text = base::Printable(reference.text);
  const auto document = documents_.find(reference.uri);
  if (document == documents_.end()) {
    return tl::unexpected(fmt::format(
        "{} refers to another document, {}: what is needed of it must stand under definitions",
        place, text));
  }
  const Value* schema = Find(reference);
  if (schema == nullptr) {
    return tl::unexpected(fmt::format("{} refers to {}, which is not there", place, text));
  }
  vetted_.targets.emplace(reference.schema, schema);
  return Found{schema, reference.fragment, document->first};
}

auto ReferenceTable::CheckChains(std::span<const Value* const> schemas) const -> Checked<void> {
  ChainWalk walk(vetted_);
  const auto refuse = [](const Reference& reference, ChainWalk::CommandStatus status) {
    const std::string place = base::Printable(reference.place);
    return tl::unexpected(
        status == ChainWalk::CommandStatus::kCycle
            ? fmt::format("{} leads in a circle through nothing but references", place)
            : fmt::format(
                  "{} belongs to a chain of more than {} schemas for one and the same value", place,
                  kLongestChain));
  };
  for (const Reference& reference : references_) {
    const auto status = walk.Walk(*reference.schema, 0);
    if (status != ChainWalk::CommandStatus::kFine) return refuse(reference, status);
  }
  for (const Value* schema : schemas) {  // a chain that begins above all references
    const auto status = walk.Walk(*schema, 0);
    if (status != ChainWalk::CommandStatus::kFine) return refuse(references_.front(), status);
  }
  return {};
}

}  // namespace fleetpub::schema
