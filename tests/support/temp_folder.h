#pragma once

#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <sstream>
#include <string>
#include <string_view>
#include <unistd.h>

namespace fumarole::test {

/// A folder of one test, removed with all that is in it. ctest runs the tests of a binary as
/// processes side by side, so its name holds the process.
class TempFolder {
public:
    TempFolder()
    {
        const auto* test = testing::UnitTest::GetInstance()->current_test_info();
        std::string name = test != nullptr ? test->name() : "test";
        for (char& c : name)
            c = c == '/' ? '_' : c;
        path_ = std::filesystem::temp_directory_path() /
                ("fumarole-" + std::to_string(getpid()) + "-" + name);
        std::filesystem::create_directories(path_);
    }
    ~TempFolder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    TempFolder(const TempFolder&) = delete;
    TempFolder& operator=(const TempFolder&) = delete;

    [[nodiscard]] const std::filesystem::path& path() const { return path_; }

    std::filesystem::path write(const std::string& name, std::string_view bytes) const
    {
        const std::filesystem::path file = path_ / name;
        // Some file systems flush a file that is cut to nothing and written anew, but not a new
        // one.
        std::filesystem::remove(file);
        std::ofstream(file, std::ios::binary) << bytes;
        return file;
    }

private:
    std::filesystem::path path_;
};

inline std::string read_bytes(const std::filesystem::path& file)
{
    std::ostringstream out;
    out << std::ifstream(file, std::ios::binary).rdbuf();
    return out.str();
}

}  // namespace fumarole::test
