// The program ends by _exit() (cli/main.cc), which neither looks for leaks nor writes coverage
// counters. In the presets that want one of them, the linker sends _exit() here first.
#ifdef FLEETPUB_COVERAGE
extern "C" void __gcov_dump();
#else
#include <sanitizer/lsan_interface.h>

#include <csignal>

namespace {

// A handler may have interrupted an allocation; while it runs, its signal is blocked.
bool InASignalHandler() {
  sigset_t blocked;
  sigprocmask(SIG_BLOCK, nullptr, &blocked);
  return sigismember(&blocked, SIGINT) == 1 || sigismember(&blocked, SIGTERM) == 1 ||
         sigismember(&blocked, SIGHUP) == 1;
}

}  // namespace
#endif

extern "C" {
[[noreturn]] void __real__exit(int code);

[[noreturn]] void __wrap__exit(int code) {
#ifdef FLEETPUB_COVERAGE
  __gcov_dump();
#else
  if (!InASignalHandler()) __lsan_do_leak_check();
#endif
  __real__exit(code);
}
}
