// Large arrays that are written before they are read.
#pragma once
#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace irradia {

/// Leaves elements that resize() adds as they are: the thread that first writes them gets their pages.
template <class T>
struct Untouched : std::allocator<T> {
    template <class U>
    struct rebind {
        using other = Untouched<U>;
    };
    template <class U>
    void construct(U* at) {
        ::new (static_cast<void*>(at)) U;
    }
    template <class U, class... Arguments>
    void construct(U* at, Arguments&&... arguments) {
        ::new (static_cast<void*>(at)) U(std::forward<Arguments>(arguments)...);
    }
};

template <class T>
using UntouchedVector = std::vector<T, Untouched<T>>;

}  // namespace irradia
