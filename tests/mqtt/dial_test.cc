#include "mqtt/dial.h"

#include <fcntl.h>
#include <poll.h>

#include <chrono>

#include "connecting.h"
#include "support/broken_broker.h"
#include "support/free_port.h"

namespace fleetpub::mqtt {
namespace {

using fleetpub::testing::BrokenBroker;
using std::chrono::milliseconds;
using ::testing::HasSubstr;
using ::testing::SizeIs;

std::vector<Address> At(std::uint16_t port) { return Lookup("127.0.0.1", port, Soon()).value(); }

TEST(Lookup, KnowsNumbersAndLocalhostWithoutAsking) {
  const Deadline past = In(milliseconds(-1));
  EXPECT_THAT(*Lookup("10.1.2.3", 1883, past), SizeIs(1));
  EXPECT_THAT(*Lookup("::1", 1883, past), SizeIs(1));
  EXPECT_THAT(*Lookup("LocalHost", 1883, past), SizeIs(2));
}

TEST(Lookup, EndsAtItsDeadline) {
  const auto addresses = Lookup("nobody.invalid", 1883, In(milliseconds(-1)));
  ASSERT_FALSE(addresses);
  EXPECT_THAT(addresses.error().message, HasSubstr("took too long"));
}

TEST(Lookup, SaysThatANameIsNotKnown) {
  const auto addresses = Lookup("nobody.invalid", 1883, Soon());
  ASSERT_FALSE(addresses);
  EXPECT_THAT(addresses.error().message, HasSubstr("nobody.invalid"));
}

TEST(Dial, ReturnsANonBlockingSocket) {
  const BrokenBroker peer(BrokenBroker::Greets("x"));
  const auto socket = Dial(At(peer.port()), Soon());
  ASSERT_TRUE(socket);
  EXPECT_NE(fcntl(socket->get(), F_GETFL) & O_NONBLOCK, 0);
  EXPECT_NE(fcntl(socket->get(), F_GETFD) & FD_CLOEXEC, 0);
  EXPECT_NE(WaitFor(socket->get(), POLLIN, Soon()) & POLLIN, 0);
}

TEST(Dial, GoesOnToTheNextAddress) {
  const BrokenBroker peer(BrokenBroker::Silent());
  auto addresses = At(fleetpub::testing::FreePort());
  addresses.push_back(At(peer.port()).front());
  EXPECT_TRUE(Dial(addresses, Soon()));
}

TEST(Dial, DoesNotWaitForAnAddressThatSaysNothing) {
  const BrokenBroker peer(BrokenBroker::Silent());
  auto addresses = *Lookup("192.0.2.1", 1883, Soon());  // RFC 5737: nobody's
  addresses.push_back(At(peer.port()).front());
  const auto start = std::chrono::steady_clock::now();
  EXPECT_TRUE(Dial(addresses, Soon()));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

TEST(Dial, TellsTheFirstReason) {
  const auto socket = Dial(At(fleetpub::testing::FreePort()), Soon());
  ASSERT_FALSE(socket);
  EXPECT_EQ(socket.error().message, "connection refused");
}

TEST(Dial, EndsAtItsDeadline) {
  const auto socket = Dial(*Lookup("192.0.2.1", 1883, Soon()), In(milliseconds(50)));
  ASSERT_FALSE(socket);
}

}  // namespace
}  // namespace fleetpub::mqtt
