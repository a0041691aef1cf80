// What a sanitizer finds ends the process there and then, whoever started it, with an exit code
// that no test expects.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() { return "exitcode=99"; }

extern "C" const char* __tsan_default_options();
extern "C" const char* __tsan_default_options() { return "halt_on_error=1:exitcode=99"; }
