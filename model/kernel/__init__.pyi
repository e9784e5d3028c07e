from .kernel import Kernel as Kernel
