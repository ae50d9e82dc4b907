// Work that is left at its pauses and taken up again.

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>
#include <string>

#include "light/steps.h"

namespace fumarole::light {
namespace {

Steps part(std::string& log, char name, int pauses)
{
    for (int i = 0; i < pauses; ++i) {
        log += name;
        const bool was_left = co_await Pause{};
        log += was_left ? "'" : "";  // something else was done meanwhile
    }
    log += ".";
}

Steps whole(std::string& log)
{
    log += "<";
    co_await part(log, 'a', 2);
    co_await part(log, 'b', 0);
    const bool was_left = co_await Pause{};
    log += was_left ? "-" : "";
    co_await part(log, 'c', 1);
    log += ">";
}

TEST(Steps, AreTakenUpWhereTheyWereLeft)
{
    std::string log;
    Steps steps = whole(log);
    EXPECT_EQ(log, "") << "nothing is done unasked";
    std::string parts;
    while (steps.resume())
        parts += std::to_string(log.size()) + " ";
    EXPECT_EQ(parts, "2 4 7 9 ");
    EXPECT_EQ(log, "<a'a'..-c'.>");
    EXPECT_EQ(steps.pauses(), 4);
}

TEST(Steps, AreFinishedWithoutAPauseFromWhereverTheyAre)
{
    for (int left = 0; left <= 4; ++left) {
        std::string log;
        Steps steps = whole(log);
        for (int i = 0; i < left; ++i)
            steps.resume();
        Steps moved = std::move(steps);
        moved.finish();
        std::string without;
        for (const char c : log)
            if (c != '\'' && c != '-')
                without += c;
        EXPECT_EQ(without, "<aa..c.>") << left;
        EXPECT_EQ(std::count(log.begin(), log.end(), '\''), std::min(left, 2) + (left == 4 ? 1 : 0))
            << left << ": what is not left is not bound again";
        EXPECT_EQ(moved.pauses(), 4) << "those that were left out count too";
    }
}

Steps failing(std::string& log, bool late)
{
    if (late)
        (void)co_await Pause{};  // Nothing is bound that would have to be bound anew.
    log += "thrown ";
    throw std::runtime_error("lost");
}

Steps around(std::string& log, bool late)
{
    struct Guard {
        std::string& log;
        ~Guard() { log += "freed "; }
    } guard{log};
    co_await failing(log, late);
    log += "unreachable ";
}

TEST(Steps, GiveOnWhatAPartThrows)
{
    for (const bool late : {false, true}) {
        std::string log;
        Steps steps = around(log, late);
        if (late) {
            EXPECT_TRUE(steps.resume());
        }
        EXPECT_THROW(steps.resume(), std::runtime_error);
        EXPECT_EQ(log, "thrown freed ");
    }
}

TEST(Steps, FreeWhatTheyHoldWhereTheyAreGivenUp)
{
    std::string log;
    {
        Steps steps = around(log, true);
        steps.resume();
        EXPECT_EQ(log, "");
        steps = Steps();
        // What was swapped out lives to the end of the statement.
    }
    EXPECT_EQ(log, "freed ");
    Steps never = around(log, true);  // nothing is held before the first step
}

}  // namespace
}  // namespace fumarole::light
