#include "ledger/postgres/postgres_url.h"

#include <gmock/gmock.h>

namespace fleetpub::ledger {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(LedgerUrl, IsToldFromAFile) {
  EXPECT_TRUE(IsUrl("postgresql://db.example/fleet"));
  EXPECT_TRUE(IsUrl("mysql://db.example/fleet"));
  EXPECT_FALSE(IsUrl("/var/lib/fleetpub/ledger.db"));
  EXPECT_FALSE(IsUrl("postgres"));
}

TEST(LedgerUrl, IsTakenAsLibpqTakesIt) {
  for (const char* url :
       {"postgresql://", "postgres://db.example", "postgresql://op@db.example:5433/fleet",
        "postgresql://op@[::1]/fleet?sslmode=verify-full&sslrootcert=/etc/ca.pem",
        "postgresql://a.example:1,b.example:2/fleet?target_session_attrs=any",
        "postgresql:///fleet?host=/run/postgresql&passfile=/etc/fleetpub/pgpass"}) {
    EXPECT_TRUE(CheckPostgresUrl(url)) << url;
  }
}

TEST(LedgerUrl, WithAPasswordIsRefusedWithoutSayingIt) {
  for (const char* url :
       {"postgresql://op:hush@db.example/fleet", "postgresql://:hush@db.example",
        "postgresql://op:hu/sh@db.example/fleet", "postgresql://op:hu?sh@db.example/fleet",
        "postgresql://db.example/fleet?password=hush", "postgresql://db.example?sslpassword=hush",
        "postgresql://db.example?sslmode=require&PassWord=hush",
        "postgresql://db.example?%70assword=hush", "postgresql:///fleet?user=a@b&password=hush"}) {
    const Status refused = CheckPostgresUrl(url);
    ASSERT_FALSE(refused) << url;
    EXPECT_EQ(refused.error().kind, ErrorKind::kUsage);
    EXPECT_THAT(refused.error().message,
                AllOf(HasSubstr("PGPASSFILE"), HasSubstr("PGPASSWORD"), Not(HasSubstr("hu"))));
    EXPECT_THAT(FormatPlace(url), Not(HasSubstr("hush"))) << url;
  }
}

TEST(LedgerUrl, OfAnotherKindIsRefused) {
  const Status refused = CheckPostgresUrl("mysql://op:hush@db.example/fleet");
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message,
              AllOf(HasSubstr("mysql://"), HasSubstr("postgresql://"), Not(HasSubstr("hush"))));
  EXPECT_FALSE(CheckPostgresUrl("postgresql://db\n.example"));
}

TEST(LedgerUrl, IsShownWithoutItsParameters) {
  EXPECT_EQ(FormatPlace("postgresql://op@db.example:5433/fleet?sslmode=require"),
            "postgresql://op@db.example:5433/fleet");
  EXPECT_EQ(FormatPlace("postgresql://op:hush@db.example/fleet"),
            "postgresql://op:********@db.example/fleet");
}

}  // namespace
}  // namespace fleetpub::ledger
