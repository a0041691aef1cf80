// A distant broker: passes on to a port of 127.0.0.1, each byte after a delay, until it is ended.
//
//   delay PORT MILLISECONDS      one way; prints the URL to connect to
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

#include "support/relay.h"

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "usage: delay PORT MILLISECONDS\n");
    return 2;
  }
  const fleetpub::testing::Relay relay(static_cast<std::uint16_t>(std::atoi(argv[1])),
                                       std::chrono::milliseconds(std::atoi(argv[2])));
  fmt::print("{}\n", relay.Url());
  std::fflush(stdout);
  for (;;) pause();
}
