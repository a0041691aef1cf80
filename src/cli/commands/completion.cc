// `fleetpub completion SHELL`: a few lines of shell that ask `fleetpub __complete`
// (shell_completion.h).
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>

#include "base/text.h"
#include "cli/parser/option_set.h"
#include "cli/parser/subcommand.h"

namespace fleetpub::cli {
namespace {

// Names come from robots: whatever one is called, it is inserted as one quoted word. bash cuts
// words at $COMP_WORDBREAKS too and replaces only what follows the last cut, $2, so the answers
// lose what comes before. `read` without -r takes backslashes off as the shell would.
constexpr std::string_view kBash =
    R"sh(# bash completion of fleetpub. Put it into ~/.local/share/bash-completion/completions/fleetpub
_fleetpub() {
  local IFS=$' \t\n' line=${COMP_LINE:0:COMP_POINT} words current part cut answer
  read -a words <<<"$line"
  read -a part <<<"$2"
  [[ $line == *[[:space:]] && $line != *\\[[:space:]] ]] && words+=("")
  current=${words[-1]}
  cut=${current%"${part[0]}"}
  COMPREPLY=()
  while IFS= read -r answer; do
    if [[ $answer == :files ]]; then
      compopt -o filenames 2>/dev/null
      while IFS= read -r answer; do COMPREPLY+=("$answer"); done < <(compgen -f -- "$current")
      continue
    fi
    answer=${answer%%$'\t'*}
    [[ $answer == *= ]] && compopt -o nospace 2>/dev/null
    answer=${answer#"$cut"}
    [[ $answer ]] && printf -v answer %q "$answer"
    COMPREPLY+=("$answer")
  done < <("${words[0]/#\~/$HOME}" __complete "${words[@]:1}" 2>/dev/null)
}
complete -o nosort -F _fleetpub fleetpub 2>/dev/null || complete -F _fleetpub fleetpub
)sh";

constexpr std::string_view kZsh = R"sh(#compdef fleetpub
# zsh completion of fleetpub. Put it into a folder of $fpath as _fleetpub
_fleetpub() {
  local answer word
  local -a whole open
  for answer in ${(f)"$($words[1] __complete ${(@Q)words[2,CURRENT-1]} "${(Q)PREFIX}" 2>/dev/null)"}; do
    if [[ $answer == :files ]]; then
      _files
      continue
    fi
    word=${${${answer%%$'\t'*}//\\/\\\\}//:/\\:}
    if [[ $word == *= ]]; then
      open+=("$word:${answer#*$'\t'}")
    else
      whole+=("$word:${answer#*$'\t'}")
    fi
  done
  (( $#whole )) && _describe -V fleetpub whole
  (( $#open )) && _describe -V fleetpub open -S ''
}
if [[ $zsh_eval_context[-1] == loadautofunc ]]; then
  _fleetpub "$@"
else
  compdef _fleetpub fleetpub
fi
)sh";

constexpr std::string_view kFish =
    R"sh(# fish completion of fleetpub. Put it into ~/.config/fish/completions/fleetpub.fish
function __fleetpub_complete
    set -l words (commandline -opc)
    set -l current (commandline -ct | string unescape)
    or set current (commandline -ct)
    for answer in ($words[1] __complete $words[2..-1] "$current" 2>/dev/null)
        if test "$answer" = :files
            __fish_complete_path "$current"
        else
            printf '%s\n' $answer
        end
    end
end
complete -c fleetpub -f -k -a '(__fleetpub_complete)'
)sh";

constexpr auto kShells = std::to_array<base::Choice<std::string_view>>(
    {{"bash", kBash}, {"zsh", kZsh}, {"fish", kFish}});

Result<ExitCode> RunCompletion(std::string_view script, const Context& context) {
  if (script.empty())
    return Fail(ErrorKind::kUsage,
                "name the shell (bash, zsh or fish). try: fleetpub completion bash");
  context.output.Line(script.substr(0, script.size() - 1));
  return ExitCode::kDone;
}

}  // namespace

Run DeclareCompletion(OptionSet& set) {
  const auto script = std::make_shared<std::string_view>();
  set.AddOption("shell", OneOf(*script, kShells), "{}").Type("SHELL");
  return [script](const Context& context) { return RunCompletion(*script, context); };
}

}  // namespace fleetpub::cli
