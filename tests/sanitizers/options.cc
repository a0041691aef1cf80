// What ThreadSanitizer finds ends the process there and then, whoever started it: so its test
// fails.
extern "C" const char* __tsan_default_options();
extern "C" const char* __tsan_default_options() { return "halt_on_error=1"; }
