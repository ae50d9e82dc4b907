#pragma once

#include <glad/gl.h>

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <fumarole/gl.h>
#include <fumarole/log.h>
#include <fumarole/program_store.h>

namespace fumarole::gl {

class StateGuard;

/// What a context can do, asked once.
struct Capabilities {
    std::string renderer;
    std::string version;
    bool software = false;  ///< a CPU rasteriser: its timer queries can't be believed
    int max_texture_2d = 0;
    int max_texture_3d = 0;
    std::int64_t max_storage_bytes = 0;  ///< most bytes of a storage buffer that shaders see
    int max_texture_units = 0;           ///< samplers that one fragment shader may use
    /// Turns that all loops of one invocation take together before they are cut off without a word
    /// (Mesa's llvmpipe); 0: as many as they like.
    int max_loop_turns = 0;
    /// GL_PROGRAM_BINARY_FORMATS; empty where the driver gives no program away.
    std::vector<GLenum> program_formats;
    std::string vendor, shading_language;
};

/// The functions and limits of the host's current context. Owns no GL object and no context. One
/// for each context: nothing here is global.
class Device {
public:
    /// @throws Error if the current context is older than OpenGL 4.5 or there is none.
    explicit Device(GetProc get_proc, Log log = {}, ProgramStore programs = {});
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    const GladGLContext* operator->() const { return &gl_; }
    [[nodiscard]] const Capabilities& capabilities() const { return capabilities_; }

    /// Tells the host something, if it listens.
    void log(LogLevel level, std::string_view line) const
    {
        if (log_)
            log_(level, line);
    }

    [[nodiscard]] const ProgramStore& programs() const { return programs_; }
    /// Whether programs can be kept between runs: a host wants it, and the driver can.
    [[nodiscard]] bool keeps_programs() const
    {
        return programs_ && !capabilities_.program_formats.empty();
    }

    /// Bytes in textures and buffers that objects of this device hold now.
    [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

    /// Textures and buffers that objects of this device have made so far, those freed since too: a
    /// frame that leaves it as it was has allocated nothing.
    [[nodiscard]] std::uint64_t allocations() const { return allocations_; }

    /// How objects keep the account, one that is made with its bytes, one that is freed with less
    /// than 0; not for others.
    void account(std::int64_t bytes) const
    {
        bytes_ += static_cast<std::uint64_t>(bytes);
        allocations_ += bytes > 0 ? 1 : 0;
    }

    /// Has the StateGuard that is at work, if one is, note a texture unit that is to be bound to.
    void take_texture_unit(GLuint unit) const;

    /// For StateGuard: the one that is at work from now on, or null. @returns the one that was
    StateGuard* set_guard(StateGuard* guard) const { return std::exchange(guard_, guard); }

private:
    GladGLContext gl_{};
    mutable StateGuard* guard_ = nullptr;
    Log log_;
    ProgramStore programs_;
    Capabilities capabilities_;
    mutable std::uint64_t bytes_ = 0, allocations_ = 0;
};

/// A move-only GL name with the device that it came from. `Destroy` frees one name.
template <void (*Destroy)(const Device&, GLuint)> class Handle {
public:
    Handle() = default;
    Handle(const Device& device, GLuint id) : device_{&device}, id_{id} {}
    Handle(Handle&& other) noexcept { swap(other); }
    Handle& operator=(Handle&& other) noexcept
    {
        Handle moved{std::move(other)};
        swap(moved);
        return *this;
    }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    ~Handle()
    {
        if (id_ != 0)
            Destroy(*device_, id_);
    }

    [[nodiscard]] GLuint id() const { return id_; }
    [[nodiscard]] const Device& device() const { return *device_; }
    explicit operator bool() const { return id_ != 0; }

private:
    void swap(Handle& other) noexcept
    {
        std::swap(device_, other.device_);
        std::swap(id_, other.id_);
    }
    const Device* device_ = nullptr;
    GLuint id_ = 0;
};

}  // namespace fumarole::gl
