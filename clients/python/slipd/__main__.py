import sys

from slipd import main

sys.exit(main())
