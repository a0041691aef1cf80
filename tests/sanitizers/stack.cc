// A sanitizer's stack frames are some times as large as they are without: what fits the usual 8 MiB
// there (the deepest message that the longest chain of references is followed in) needs more here.
#include <sys/resource.h>

#include <algorithm>

namespace {

bool RaiseTheLimit() {
  rlimit limit{};
  getrlimit(RLIMIT_STACK, &limit);
  limit.rlim_cur = std::min<rlim_t>(limit.rlim_max, 64 << 20);
  return setrlimit(RLIMIT_STACK, &limit) == 0;
}

[[maybe_unused]] const bool kRaised = RaiseTheLimit();

}  // namespace
