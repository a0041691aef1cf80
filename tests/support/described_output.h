#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fleetpub::testing {

/// Fails the test unless each object that `fleetpub` printed for these arguments (the first is the
/// program) is as the schema of its kind says. Other programs and other output pass.
void ExpectDescribed(const std::vector<std::string>& arguments, std::string_view output);

}  // namespace fleetpub::testing
