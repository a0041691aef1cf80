#include "cli/parser/option.h"

#include <CLI/CLI.hpp>

namespace fleetpub::cli {

Option Option::Type(const std::string& name) const {
  option_->type_name(name);
  return *this;
}

Option Option::Group(const std::string& name) const {
  option_->group(name);
  return *this;
}

Option Option::Variable(const std::string& name) const {
  option_->envname(name);
  return *this;
}

Option Option::OneValueEach() const {
  option_->allow_extra_args(false);
  return *this;
}

Option Option::InRange(std::int64_t least, std::int64_t most) const {
  option_->check(CLI::Range(least, most));
  return *this;
}

bool Option::IsGiven() const { return option_ != nullptr && !option_->empty(); }
bool Option::IsPositional() const { return option_->get_positional(); }
bool Option::TakesValue() const { return option_->get_items_expected_max() > 0; }
bool Option::IsRepeatable() const { return option_->get_items_expected_max() > 1; }
const std::vector<std::string>& Option::short_names() const { return option_->get_snames(); }
const std::vector<std::string>& Option::long_names() const { return option_->get_lnames(); }
std::string Option::position_name() const { return option_->get_name(true); }
std::string Option::type() const {
  const std::string type = option_->get_type_name();
  return type.substr(0, type.find(':'));  // CLI11 adds its validators
}
const std::string& Option::group() const { return option_->get_group(); }
const std::string& Option::description() const { return option_->get_description(); }
std::string Option::variable() const { return option_->get_envname(); }

}  // namespace fleetpub::cli
