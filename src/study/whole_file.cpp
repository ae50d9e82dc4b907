#include "study/whole_file.h"

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <sstream>
#include <unistd.h>

#include <fumarole/errors.h>

namespace fumarole::study {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& file, int error)
{
    throw Error(fmt::format("{}: {}", file.string(), std::strerror(error != 0 ? error : EIO)));
}

}  // namespace

UnfinishedFile::UnfinishedFile(fs::path file) : file_{std::move(file)}
{
    static std::atomic<unsigned> counter{0};
    path_ = file_.parent_path() /
            fmt::format(".fumarole-{}-{}.part{}", getpid(), counter++, file_.extension().string());
}

UnfinishedFile::~UnfinishedFile()
{
    std::error_code ignored;
    fs::remove(path_, ignored);
}

void UnfinishedFile::finish()
{
    std::error_code error;
    fs::rename(path_, file_, error);
    if (error)
        fail(file_, error.value());
}

void write_whole(const fs::path& file, std::string_view bytes)
{
    UnfinishedFile unfinished(file);
    errno = 0;
    std::FILE* stream = std::fopen(unfinished.path().c_str(), "wbx");
    if (stream == nullptr)
        fail(file, errno);
    const bool written = std::fwrite(bytes.data(), 1, bytes.size(), stream) == bytes.size() &&
                         std::fflush(stream) == 0;
    const int error = errno;
    if (std::fclose(stream) != 0 || !written)
        fail(file, error);
    unfinished.finish();
}

std::string read_whole(const fs::path& file)
{
    errno = 0;
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream bytes;
    bytes << stream.rdbuf();
    if (!stream || fs::is_directory(file))
        fail(file, errno != 0 ? errno : EISDIR);
    return bytes.str();
}

}  // namespace fumarole::study
