#include "tools/lab/base/table.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace leeway::tools::report {
namespace {

Table sample() {
  Table table({"name", "count", "time [s]:.2f", "share"});
  table.add({"plain", 3, 1.0, 0.123456});
  table.add({"a, b and \"c\"", -1L, std::nan(""), Table::Cell::onlyIf(false, 7)});
  return table;
}

TEST(Table, CsvLeavesOutWhatIsNotANumberAndQuotes) {
  EXPECT_EQ(sample().csv(),
            "name,count,time [s],share\n"
            "plain,3,1.00,0.1235\n"
            "\"a, b and \"\"c\"\"\",-1,,\n");
}

TEST(Table, JsonHasAllDigitsAndNullForWhatIsNotANumber) {
  EXPECT_EQ(sample().json().dump(),
            R"([{"name":"plain","count":3,"time [s]":1.0,"share":0.123456},)"
            R"({"name":"a, b and \"c\"","count":-1,"time [s]":null,"share":null}])");
  EXPECT_EQ(Table({"none"}).json().dump(), "[]");
}

TEST(Table, PeopleSeeDashes) {
  EXPECT_EQ(sample().heading(), (std::vector<std::string>{"name", "count", "time [s]", "share"}));
  EXPECT_EQ(sample().rows()[1], (std::vector<std::string>{"a, b and \"c\"", "-1", "-", "-"}));
  EXPECT_EQ(sample().textColumns(), std::vector<std::size_t>{0});
}

TEST(Table, PeopleSeeWhatNamesARowInOneColumn) {
  Table table({"family", "engine", "ns", "status"}, 2);
  table.add({"boxes", "ours", 12, "solved"});
  EXPECT_EQ(table.heading(), (std::vector<std::string>{"family, engine", "ns", "status"}));
  EXPECT_EQ(table.rows()[0], (std::vector<std::string>{"boxes, ours", "12", "solved"}));
  EXPECT_EQ(table.textColumns(), (std::vector<std::size_t>{0, 2}));
  EXPECT_EQ(table.csv(), "family,engine,ns,status\nboxes,ours,12,solved\n");
}

TEST(Table, ARowHasACellForEachColumn) {
  EXPECT_THROW(sample().add({"short", 1}), std::logic_error);
}

}  // namespace
}  // namespace leeway::tools::report
