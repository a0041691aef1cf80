// Parses and validates one instantActions message over and over in one thread, for as many seconds
// as asked, and prints how often it did per second: the counterpart of ajv_validation.mjs.
#include <fmt/format.h>

#include <chrono>
#include <cstdlib>

#include "base/file.h"
#include "base/json.h"
#include "schema/schema.h"

int main(int argc, char** argv) {
  using std::chrono::steady_clock;
  if (argc != 4) {
    fmt::print(stderr, "usage: validation SCHEMA_NAME MESSAGE_FILE SECONDS\n");
    return 2;
  }
  fleetpub::schema::Registry registry;
  const auto schema = registry.Find(argv[1]);
  const auto text = fleetpub::base::ReadFile(argv[2]);
  if (!schema || !text) return 1;
  const std::chrono::duration<double> limit(std::atof(argv[3]));
  const auto start = steady_clock::now();
  long count = 0;
  std::chrono::duration<double> elapsed{};
  while ((elapsed = steady_clock::now() - start) < limit) {
    for (int i = 0; i < 1000; ++i, ++count) {
      const auto message = fleetpub::base::ParseJson(*text);
      if (!message || !(*schema)->Validate(*message).empty()) return 1;
    }
  }
  fmt::print("{:.0f}\n", static_cast<double>(count) / elapsed.count());
  return 0;
}
