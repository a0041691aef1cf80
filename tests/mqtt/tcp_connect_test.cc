#include "mqtt/tcp_connect.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <chrono>
#include <stdexcept>

#include "mqtt/connecting.h"
#include "support/broken_broker.h"
#include "support/free_port.h"

namespace fleetpub::mqtt {
namespace {

using fleetpub::testing::BrokenBroker;
using std::chrono::milliseconds;
using ::testing::HasSubstr;
using ::testing::SizeIs;

std::vector<Address> At(std::uint16_t port) { return Lookup("127.0.0.1", port, Soon()).value(); }

// A listener whose queue is full: the system drops every further attempt without an answer.
class Unresponsive {
 public:
  Unresponsive() : listener_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t length = sizeof address;
    auto* const generic = reinterpret_cast<sockaddr*>(&address);
    if (bind(listener_.get(), generic, length) != 0 || listen(listener_.get(), 0) != 0 ||
        getsockname(listener_.get(), generic, &length) != 0) {
      throw std::runtime_error("no listener");
    }
    port_ = ntohs(address.sin_port);
    for (Descriptor& filler : fillers_) {
      filler = Descriptor(socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
      static_cast<void>(connect(filler.get(), generic, length));
    }
  }
  [[nodiscard]] std::uint16_t port() const { return port_; }

 private:
  Descriptor listener_;
  std::array<Descriptor, 4> fillers_;
  std::uint16_t port_ = 0;
};

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

TEST(TcpConnect, ReturnsANonBlockingSocket) {
  const BrokenBroker peer(BrokenBroker::Greets("x"));
  const auto socket = TcpConnect(At(peer.port()), Soon());
  ASSERT_TRUE(socket);
  EXPECT_NE(fcntl(socket->get(), F_GETFL) & O_NONBLOCK, 0);
  EXPECT_NE(fcntl(socket->get(), F_GETFD) & FD_CLOEXEC, 0);
  EXPECT_NE(WaitFor(socket->get(), POLLIN, Soon()) & POLLIN, 0);
}

TEST(TcpConnect, GoesOnToTheNextAddress) {
  const BrokenBroker peer(BrokenBroker::Silent());
  auto addresses = At(fleetpub::testing::FreePort());
  addresses.push_back(At(peer.port()).front());
  EXPECT_TRUE(TcpConnect(addresses, Soon()));
}

TEST(TcpConnect, DoesNotWaitForAnAddressThatSaysNothing) {
  const BrokenBroker peer(BrokenBroker::Silent());
  const Unresponsive dead;
  auto addresses = At(dead.port());
  addresses.push_back(At(peer.port()).front());
  const auto start = std::chrono::steady_clock::now();
  EXPECT_TRUE(TcpConnect(addresses, Soon()));
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(5));
}

TEST(TcpConnect, TellsTheFirstReason) {
  const auto socket = TcpConnect(At(fleetpub::testing::FreePort()), Soon());
  ASSERT_FALSE(socket);
  EXPECT_EQ(socket.error().message, "connection refused");
}

TEST(TcpConnect, EndsAtItsDeadline) {
  const Unresponsive dead;
  const auto socket = TcpConnect(At(dead.port()), In(milliseconds(50)));
  ASSERT_FALSE(socket);
  EXPECT_EQ(socket.error().message, "no answer");
}

}  // namespace
}  // namespace fleetpub::mqtt
