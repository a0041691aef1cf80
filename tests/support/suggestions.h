// Commands that texts suggest, read as a shell would read them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace fleetpub::testing {

/// What follows each `try: ` of a text: to the end of its line.
[[nodiscard]] std::vector<std::string> FindSuggestions(std::string_view text);

/// The same of the literals in our sources: whatever is printed is made of them. A placeholder is a
/// number, and what a literal leaves open to an expression behind it is not there.
[[nodiscard]] std::vector<std::string> FindSuggestionsInSources();

/// The arguments that a shell would call `fleetpub ARGUMENTS…` with, without a redirection at the
/// end. The test fails when that is no call of fleetpub.
[[nodiscard]] std::vector<std::string> ReadAsShell(const std::string& line);

/// The test fails when fleetpub's parser refuses the line.
void ExpectUnderstood(const std::string& line);

}  // namespace fleetpub::testing
