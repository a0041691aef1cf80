#include "cli/parser/option.h"

#include <CLI/CLI.hpp>

namespace fleetpub::cli {

Option Option::Type(std::string_view name) const {
  if (record_->option != nullptr) record_->option->type_name(std::string(name));
  return *this;
}

Option Option::Group(const std::string& name) const {
  if (record_->option != nullptr) record_->option->group(name);
  return *this;
}

Option Option::Variable(const std::string& name) const {
  if (record_->option != nullptr) record_->option->envname(name);
  return *this;
}

Option Option::OneValueEach() const {
  if (record_->option != nullptr) record_->option->allow_extra_args(false);
  return *this;
}

Option Option::Key(std::string_view key) const {
  record_->key = key;
  return *this;
}

bool Option::IsGiven() const {
  return record_ != nullptr && record_->option != nullptr && !record_->option->empty();
}
bool Option::IsPositional() const { return record_->option->get_positional(); }
bool Option::TakesValue() const { return record_->option->get_items_expected_max() > 0; }
bool Option::IsRepeatable() const { return record_->option->get_items_expected_max() > 1; }
const std::vector<std::string>& Option::short_names() const {
  return record_->option->get_snames();
}
const std::vector<std::string>& Option::long_names() const { return record_->option->get_lnames(); }
std::string Option::position_name() const { return record_->option->get_name(true); }
std::string Option::type() const { return record_->option->get_type_name(); }
const std::string& Option::group() const { return record_->option->get_group(); }
const std::string& Option::description() const { return record_->option->get_description(); }
std::string Option::variable() const { return record_->option->get_envname(); }
const std::vector<std::string>& Option::texts() const { return record_->option->results(); }

std::vector<std::string_view> Option::Choices(std::optional<vda5050::Version> version) const {
  const ValueKind& kind = record_->kind;
  auto choices = kind.choices ? kind.choices() : std::vector<std::string_view>();
  if (kind.exists_in != nullptr && version) {
    std::erase_if(choices, [&](std::string_view one) { return !kind.exists_in(one, *version); });
  }
  return choices;
}

void Option::Forget() const {
  if (IsGiven()) record_->option->clear();
}

}  // namespace fleetpub::cli
