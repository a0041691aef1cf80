#include "schema/references.h"

#include <fmt/format.h>

#include <utility>

#include "base/json.h"
#include "base/text.h"
#include "schema/schema_loader.h"
#include "schema/uri.h"

namespace fleetpub::schema {
namespace {

using Value = base::JsonValue;
using Node = SchemaNode;

// The walk's stack holds this many schemas for each level of the message (base::JsonLimits::depth).
constexpr int kLongestChain = 32;

// Finds the longest chain of schemas that apply to one and the same value.
class ChainWalk {
 public:
  enum class Result { kFine, kCycle, kTooLong };

  Result Walk(const Node& schema, int level) {
    if (level > kLongestChain) return Result::kTooLong;
    const auto [entry, is_new] = below_.emplace(&schema, kOpen);
    int& below = entry->second;
    if (!is_new && below == kOpen) return Result::kCycle;
    if (!is_new) return level + below > kLongestChain ? Result::kTooLong : Result::kFine;
    int longest = 0;
    Result result = Result::kFine;
    ForEachApplied(schema, [&](const Node* applied) {
      if (applied == nullptr || result != Result::kFine) return;
      result = Walk(*applied, level + 1);
      if (result == Result::kFine) longest = std::max(longest, below_[applied] + 1);
    });
    below = longest;
    return result;
  }

 private:
  template <typename Function>
  static void ForEachApplied(const Node& schema, const Function& apply) {
    for (const Node* one :
         {schema.reference, schema.excluded, schema.condition, schema.then, schema.otherwise}) {
      apply(one);
    }
    for (const auto* list : {&schema.all_of, &schema.any_of, &schema.one_of}) {
      for (const Node* one : *list) apply(one);
    }
    for (const Node::Dependency& dependency : schema.dependencies) apply(dependency.schema);
  }

  static constexpr int kOpen = -1;
  std::unordered_map<const Node*, int> below_;  // length of the longest chain that begins here
};

}  // namespace

std::string Place::Pointer() const {
  if (up == nullptr) return std::string(prefix);
  const std::string above = up->Pointer();
  if (name.data() == nullptr) return fmt::format("{}/{}", above, index);
  return fmt::format("{}/{}", above, base::PointerToken(name));
}

const Value* FollowPointer(const Value& document, std::string_view pointer) {
  if (pointer.empty()) return &document;
  if (pointer.front() != '/') return nullptr;  // `#…` is a URI to RapidJSON
  const base::JsonPointer way(pointer.data(), pointer.size());
  return way.IsValid() ? way.Get(document) : nullptr;
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

void ReferenceTable::Add(Node& from, std::string_view reference, const Place& place) {
  auto [uri, fragment] = SplitFragment(ResolveUri(place.base, reference));
  references_.push_back(
      {&from, std::string(reference), std::move(uri), std::move(fragment), place.Pointer()});
}

const Value* ReferenceTable::Find(const Reference& reference) const {
  if (!reference.fragment.empty() && !reference.fragment.starts_with('/')) {
    const auto anchor = anchors_.find(reference.uri + "#" + reference.fragment);
    return anchor == anchors_.end() ? nullptr : anchor->second;
  }
  return FollowPointer(*documents_.at(reference.uri), reference.fragment);
}

auto ReferenceTable::Resolve(std::size_t index) -> Checked<Found> {
  const Reference& reference = references_[index];
  const std::string place = base::Printable(reference.place);
  const std::string text = base::Printable(reference.text);
  const auto document = documents_.find(reference.uri);
  if (document == documents_.end()) {
    return tl::unexpected(fmt::format(
        "{} refers to another document, {}: what is needed of it must be under definitions", place,
        text));
  }
  const Value* schema = Find(reference);
  if (schema == nullptr) {
    return tl::unexpected(fmt::format("{} refers to {}, which is not there", place, text));
  }
  return Found{reference.from, schema, reference.fragment, document->first};
}

auto ReferenceTable::CheckChains(const std::deque<Node>& schemas) const -> Checked<void> {
  if (references_.empty()) return {};
  ChainWalk walk;
  const auto check = [&walk](const Node& schema, const Reference& reference) -> Checked<void> {
    const auto result = walk.Walk(schema, 0);
    if (result == ChainWalk::Result::kFine) return {};
    const std::string place = base::Printable(reference.place);
    return tl::unexpected(
        result == ChainWalk::Result::kCycle
            ? fmt::format("{} leads in a circle through nothing but references", place)
            : fmt::format(
                  "{} belongs to a chain of more than {} schemas for one and the same value", place,
                  kLongestChain));
  };
  for (const Reference& reference : references_) {
    if (auto checked = check(*reference.from, reference); !checked) return checked;
  }
  for (const Node& schema : schemas) {  // a chain that begins above all references
    if (auto checked = check(schema, references_.front()); !checked) return checked;
  }
  return {};
}

}  // namespace fleetpub::schema
