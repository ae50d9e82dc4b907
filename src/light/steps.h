#pragma once

#include <coroutine>
#include <exception>
#include <utility>

namespace fumarole::light {

/// Work that may be left at its pauses and taken up again: a coroutine that says
/// `co_await Pause{}` where it may, and `co_await other_steps()` for a part of it that may too.
/// Nothing of it is done before resume(); it is given up by its end of life.
///
/// GCC 12 lays out wrongly what a coroutine holds that says `if (co_await ...)` and has no variable
/// at its outermost level (its bug 106188): such a one crashes at its first step.
class [[nodiscard]] Steps {
public:
    struct promise_type;
    using Handle = std::coroutine_handle<promise_type>;

    Steps() = default;
    Steps(Steps&& other) noexcept : handle_{std::exchange(other.handle_, {})} {}
    Steps& operator=(Steps&& other) noexcept
    {
        std::swap(handle_, other.handle_);
        return *this;
    }
    ~Steps()
    {
        if (handle_)
            handle_.destroy();
    }

    /// Goes on to the next pause. @returns false once all is done
    bool resume();
    /// Does all that is left, without a pause.
    void finish();
    /// Number of pauses so far, with those that were left out.
    [[nodiscard]] int pauses() const;

    // A part of other steps.
    struct Part {
        Handle own;
        [[nodiscard]] bool await_ready() const noexcept { return false; }
        std::coroutine_handle<> await_suspend(Handle caller) const noexcept;
        void await_resume() const;
    };
    Part operator co_await() const&& noexcept { return {handle_}; }

private:
    explicit Steps(Handle handle) : handle_{handle} {}
    Handle handle_;
};

/// @returns true if something else was done meanwhile: what was bound is to be bound anew
struct Pause {
    bool was_left = false;
    [[nodiscard]] bool await_ready() const noexcept { return false; }
    bool await_suspend(Steps::Handle here) noexcept;
    [[nodiscard]] bool await_resume() const noexcept;
};

struct Steps::promise_type {
    promise_type* whole = this;  ///< the steps that these are a part of in the end
    Handle caller, innermost;    ///< innermost: of the whole, what is to be resumed
    bool leaves = true;          ///< of the whole: whether it pauses
    int pauses = 0;              ///< likewise
    std::exception_ptr error;

    struct Final {
        [[nodiscard]] bool await_ready() const noexcept { return false; }
        std::coroutine_handle<> await_suspend(Handle ended) const noexcept
        {
            const Handle next = ended.promise().caller;
            if (!next)
                return std::noop_coroutine();
            ended.promise().whole->innermost = next;
            return next;
        }
        void await_resume() const noexcept {}
    };

    Steps get_return_object()
    {
        innermost = Handle::from_promise(*this);
        return Steps(innermost);
    }
    [[nodiscard]] std::suspend_always initial_suspend() const noexcept { return {}; }
    [[nodiscard]] Final final_suspend() const noexcept { return {}; }
    void return_void() const noexcept {}
    void unhandled_exception() noexcept { error = std::current_exception(); }
};

inline std::coroutine_handle<> Steps::Part::await_suspend(Handle caller) const noexcept
{
    promise_type& part = own.promise();
    part.caller = caller;
    part.whole = caller.promise().whole;
    part.whole->innermost = own;
    return own;
}

inline void Steps::Part::await_resume() const
{
    if (own.promise().error)
        std::rethrow_exception(own.promise().error);
}

inline bool Pause::await_suspend(Steps::Handle here) noexcept
{
    ++here.promise().whole->pauses;
    was_left = here.promise().whole->leaves;
    return was_left;
}

inline bool Pause::await_resume() const noexcept
{
    return was_left;
}

inline bool Steps::resume()
{
    handle_.promise().innermost.resume();
    if (!handle_.done())
        return true;
    if (handle_.promise().error)
        std::rethrow_exception(handle_.promise().error);
    return false;
}

inline int Steps::pauses() const
{
    return handle_.promise().pauses;
}

inline void Steps::finish()
{
    handle_.promise().leaves = false;
    while (resume()) {
    }
}

}  // namespace fumarole::light
