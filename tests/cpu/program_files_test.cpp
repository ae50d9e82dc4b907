// Compiled programs between runs: files that are damaged, foreign, too many or can't be written are
// done without.

#include <atomic>
#include <set>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

#include "context/program_files.h"
#include "gl/program_binary.h"
#include "support/temp_folder.h"

namespace fumarole::test {
namespace {

namespace fs = std::filesystem;
using gl::ProgramBinary;
using gl::ProgramFiles;

std::vector<std::byte> bytes_of(std::size_t count, int seed)
{
    std::vector<std::byte> bytes;
    for (std::size_t i = 0; i < count; ++i)
        bytes.push_back(static_cast<std::byte>(i * 7 + static_cast<std::size_t>(seed)));
    return bytes;
}

TEST(ProgramBinary, ComesBackWholeOrNotAtAll)
{
    const std::string key = gl::program_key({"driver", "source"});
    ASSERT_EQ(key.size(), 32u);
    const ProgramBinary program{0x875f, bytes_of(300, 1)};
    const std::vector<std::byte> packed = gl::pack_program(program, key);
    EXPECT_EQ(gl::unpack_program(packed, key), program);
    EXPECT_EQ(gl::unpack_program({}, key), std::nullopt);
    for (std::size_t length = 0; length < packed.size(); ++length)
        EXPECT_EQ(gl::unpack_program({packed.begin(), packed.begin() + long(length)}, key),
                  std::nullopt)
            << length;
    for (std::size_t i = 0; i < packed.size(); ++i) {
        std::vector<std::byte> damaged = packed;
        damaged[i] ^= std::byte{4};
        EXPECT_EQ(gl::unpack_program(damaged, key), std::nullopt) << "a bit of byte " << i;
    }
    EXPECT_EQ(gl::unpack_program(packed, gl::program_key({"another"})), std::nullopt);
}

TEST(ProgramBinary, AKeyIsOfEveryTextAndWhereItEnds)
{
    const std::vector<std::vector<std::string_view>> all{{"driver 1", "vertex", "void main() {}"},
                                                         {"driver 2", "vertex", "void main() {}"},
                                                         {"driver 1", "vertexvoid", " main() {}"},
                                                         {"driver 1", "fragment", "void main() {}"},
                                                         {"driver 1", "void main() {}", "vertex"},
                                                         {"driver 1", "vertex", "void main() {} "},
                                                         {"driver 1", "vertex"},
                                                         {}};
    std::set<std::string> keys;
    for (const auto& texts : all)
        keys.insert(gl::program_key(texts));
    EXPECT_EQ(keys.size(), all.size());
    EXPECT_EQ(gl::program_key(all[0]), gl::program_key(all[0]));
}

TEST(ProgramFiles, KeepsForAnotherRun)
{
    const TempFolder folder;
    const fs::path cache = folder.path() / "not" / "there yet";
    const auto first = std::make_shared<ProgramFiles>(cache);
    EXPECT_TRUE(first->store().load("key").empty());
    first->store().store("key", bytes_of(100, 2));
    EXPECT_EQ(first->account().stored, 1);
    const auto second = std::make_shared<ProgramFiles>(cache);
    EXPECT_EQ(second->store().load("key"), bytes_of(100, 2));
    EXPECT_EQ(second->account().loaded, 1);
    second->store().store("key", bytes_of(50, 3));
    EXPECT_EQ(first->store().load("key"), bytes_of(50, 3));
    EXPECT_EQ(std::distance(fs::directory_iterator(cache), fs::directory_iterator()), 1);
    EXPECT_EQ(fs::status(cache).permissions(), fs::perms::owner_all);
    // A pipe and a folder of a program's name are no programs, and nothing waits for them.
    ASSERT_EQ(mkfifo((cache / "pipe.program").c_str(), 0600), 0);
    fs::create_directory(cache / "folder.program");
    EXPECT_TRUE(second->store().load("pipe").empty());
    EXPECT_TRUE(second->store().load("folder").empty());
}

TEST(ProgramFiles, TheOldestMakeRoom)
{
    const TempFolder folder;
    const auto write = [&](const char* key) {
        std::make_shared<ProgramFiles>(folder.path(), 4000)->store().store(key, bytes_of(1000, 0));
    };
    const auto age = [&](const char* key, int hours) {
        fs::last_write_time(folder.path() / (std::string(key) + ".program"),
                            fs::file_time_type::clock::now() - std::chrono::hours(hours));
    };
    for (const auto& [key, hours] : {std::pair{"a", 9}, {"b", 8}, {"c", 7}, {"d", 6}}) {
        write(key);
        age(key, hours);
    }
    folder.write("killed.1.1.unfinished", "half");
    fs::last_write_time(folder.path() / "killed.1.1.unfinished",
                        fs::file_time_type::clock::now() - std::chrono::hours(2));
    folder.write("mine", "is not touched");
    // What is used stays though it is the oldest.
    EXPECT_FALSE(std::make_shared<ProgramFiles>(folder.path())->store().load("a").empty());
    write("e");
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder.path()))
        names.insert(entry.path().filename().string());
    EXPECT_EQ(names, (std::set<std::string>{"a.program", "d.program", "e.program", "mine"}));
}

TEST(ProgramFiles, WhatCantBeWrittenIsDoneWithout)
{
    const TempFolder folder;
    folder.write("file", "no folder");
    const auto below_a_file = std::make_shared<ProgramFiles>(folder.path() / "file" / "cache");
    below_a_file->store().store("key", bytes_of(10, 0));
    EXPECT_NE(below_a_file->account().refusal.find("can't be written"), std::string::npos);
    EXPECT_EQ(below_a_file->account().stored, 0);
    EXPECT_TRUE(below_a_file->store().load("key").empty());
    // What is written in full and can't take its place leaves nothing behind.
    fs::create_directories(folder.path() / "cache" / "key.program" / "in the way");
    const auto blocked = std::make_shared<ProgramFiles>(folder.path() / "cache");
    blocked->store().store("key", bytes_of(10, 0));
    EXPECT_FALSE(blocked->account().refusal.empty());
    EXPECT_EQ(
        std::distance(fs::directory_iterator(folder.path() / "cache"), fs::directory_iterator()),
        1);
}

TEST(ProgramFiles, ManyAtOnceReadWholeFiles)
{
    const TempFolder folder;
    std::vector<std::thread> runs;
    std::atomic<int> torn = 0;
    const std::string key = gl::program_key({"the same program"});
    for (int run = 0; run < 4; ++run)
        runs.emplace_back([&, run] {
            const auto files = std::make_shared<ProgramFiles>(folder.path(), 20000);
            const ProgramStore store = files->store();
            for (int i = 0; i < 50; ++i) {
                const ProgramBinary program{1, bytes_of(3000, run)};
                store.store(key, gl::pack_program(program, key));
                const std::vector<std::byte> read = store.load(key);
                if (read.empty() || !gl::unpack_program(read, key))
                    ++torn;
            }
        });
    for (std::thread& run : runs)
        run.join();
    EXPECT_EQ(torn, 0);
}

TEST(ProgramFiles, LieInTheCacheOfTheUser)
{
    const auto at = [](const char* cache, const char* home) {
        const auto set = [](const char* name, const char* value) {
            value != nullptr ? setenv(name, value, 1) : unsetenv(name);
        };
        const std::string old_home = getenv("HOME") != nullptr ? getenv("HOME") : "";
        const char* old = getenv("XDG_CACHE_HOME");
        const std::string old_cache = old != nullptr ? old : "";
        set("XDG_CACHE_HOME", cache);
        set("HOME", home);
        const auto folder = gl::program_folder();
        set("XDG_CACHE_HOME", old != nullptr ? old_cache.c_str() : nullptr);
        set("HOME", old_home.c_str());
        return folder;
    };
    EXPECT_EQ(at("/cache", "/home/me"), fs::path("/cache/fumarole"));
    EXPECT_EQ(at(nullptr, "/home/me"), fs::path("/home/me/.cache/fumarole"));
    EXPECT_EQ(at("not/absolute", "/home/me"), fs::path("/home/me/.cache/fumarole"));
    EXPECT_EQ(at("", nullptr), std::nullopt);
}

}  // namespace
}  // namespace fumarole::test
