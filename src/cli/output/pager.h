// Long texts on a terminal.
#pragma once

#include <string_view>

namespace fleetpub::cli {

/// Shows the text through $PAGER, else less, when standard output is a terminal. False: nothing was
/// shown, since it is none, no pager is wanted (`PAGER=`, TERM=dumb), or it could not be started.
[[nodiscard]] bool ShowInPager(std::string_view text);

}  // namespace fleetpub::cli
