// What may stand next on a command line that somebody is typing: asked by the scripts that
// `fleetpub completion SHELL` prints.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cli/output/exit_code.h"

namespace fleetpub::cli {

/// The first argument of a process that is asked for candidates.
inline constexpr std::string_view kCompleteWord = "__complete";

struct Candidate {
  std::string text;     ///< the whole word, of which the typed one is the beginning
  std::string meaning;  ///< one line; may be empty
};

struct Candidates {
  std::vector<Candidate> words;
  bool files = false;  ///< names of files and folders fit too
};

/// `words` are those behind the program's name, up to and with the one being typed, which may be
/// empty. Reads configuration and ledger, connects to nothing. Whatever goes wrong there means
/// fewer candidates.
[[nodiscard]] Candidates CandidatesFor(std::vector<std::string> words);

/// `__complete WORD...`: a line per candidate, `WORD<tab>MEANING`, then `:files` if they fit.
ExitCode PrintCandidates(const std::vector<std::string>& arguments);

}  // namespace fleetpub::cli
