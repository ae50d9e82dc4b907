#include "gl/counter_readback.h"

#include "gl/label.h"
#include <fumarole/errors.h>

namespace fumarole::gl {

namespace {

constexpr GLintptr kBytes = sizeof(std::uint32_t);

}  // namespace

CounterReadback::CounterReadback(const Device& device) : device_{device}
{
    constexpr GLbitfield kAccess = GL_MAP_READ_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
    constexpr GLsizeiptr kAll = kBytes * static_cast<GLsizeiptr>(kMost);
    device->CreateBuffers(1, &buffer_);
    set_label(device, GL_BUFFER, buffer_, "counters read back");
    device->NamedBufferStorage(buffer_, kAll, nullptr, kAccess | GL_CLIENT_STORAGE_BIT);
    mapped_ = static_cast<const volatile std::uint32_t*>(
        device->MapNamedBufferRange(buffer_, 0, kAll, kAccess));
    if (mapped_ == nullptr) {
        device->DeleteBuffers(1, &buffer_);
        throw Error("OpenGL: no memory to read counters back");
    }
}

CounterReadback::~CounterReadback()
{
    for (const Asked& asked : asked_)
        if (asked.fence != nullptr)
            device_->DeleteSync(asked.fence);
    device_->DeleteBuffers(1, &buffer_);  // unmaps it
}

void CounterReadback::ask(GLuint buffer)
{
    for (std::size_t i = 0; i < kMost; ++i) {
        Asked& asked = asked_.at(i);
        if (asked.fence != nullptr)
            continue;
        device_->CopyNamedBufferSubData(buffer, buffer_, 0, static_cast<GLintptr>(i) * kBytes,
                                        kBytes);
        asked = {device_->FenceSync(GL_SYNC_GPU_COMMANDS_COMPLETE, 0), ++turn_};
        return;
    }
}

std::optional<std::uint32_t> CounterReadback::take()
{
    std::optional<std::uint32_t> last;
    std::uint64_t turn = 0;
    for (std::size_t i = 0; i < kMost; ++i) {
        Asked& asked = asked_.at(i);
        if (asked.fence == nullptr)
            continue;
        const GLenum state = device_->ClientWaitSync(asked.fence, 0, 0);
        if (state != GL_ALREADY_SIGNALED && state != GL_CONDITION_SATISFIED)
            continue;
        device_->DeleteSync(asked.fence);
        asked.fence = nullptr;
        if (asked.turn > turn) {
            turn = asked.turn;
            last = mapped_[i];
        }
    }
    return last;
}

}  // namespace fumarole::gl
